// SPDX-License-Identifier: MIT
// The groups of rows of a model whose residuals are correlated.
#pragma once

#include <memory>
#include <vector>

#include "correlation/correlation_structure.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"
#include "silvafit/fit/variance_function.hpp"

namespace silvafit::fit {

class CorrelatedRows {
 public:
  struct Block {
    std::vector<Index> rows{};  ///< (n) observations, of one column in ascending order of it
    MatrixXd places{};          ///< (n x d) as CorrelationStructure::place() has them
  };
  using Factors = std::vector<std::unique_ptr<CorrelationFactor>>;

  /// The blocks of a model, null if its residuals are independent.
  /// \param known  the structure of a fit, whose times and units are used; null: those of the rows
  /// \throws InputError if a time or position is missing or repeated in a group, naming both; if
  ///   times of ar1 or arma are not integers; if no group has two rows, or a group is too large;
  ///   UsageError with crossed groups
  static std::shared_ptr<const CorrelatedRows> of(const NonlinearModel& model,
                                                  const CorrelationEstimate* known = nullptr);

  const CorrelationStructure& structure() const { return structure_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  /// First block of one of the model's groups; first_block(group_count()) is their number.
  std::size_t first_block(Index group) const {
    return first_block_[static_cast<std::size_t>(group)];
  }
  /// L of each block; empty if one is singular.
  Factors factors(const VectorXd& parameters, unsigned threads) const;
  /// The same at estimates, for which no block is singular.
  /// \throws NumericalError if one is
  Factors factors(const CorrelationEstimate& estimate) const;
  /// Applies a function of a factor and a block's rows (n x c) to the rows of all blocks.
  /// \param rows  (N x c)
  template <typename Change>
  void change(const Factors& factors, Eigen::Ref<MatrixXd> rows, const Change& by) const {
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      MatrixXd part = rows(blocks_[k].rows, Eigen::all);
      by(*factors[k], part);
      rows(blocks_[k].rows, Eigen::all) = part;
    }
  }

 private:
  CorrelatedRows(CorrelationStructure structure,
                 std::vector<Block> blocks,
                 std::vector<std::size_t> first_block)
      : structure_(std::move(structure)),
        blocks_(std::move(blocks)),
        first_block_(std::move(first_block)) {}

  CorrelationStructure structure_;
  std::vector<Block> blocks_;
  std::vector<std::size_t> first_block_;
};

/// \throws InputError if a symmetric structure does not have the time
void require_known_time(const CorrelationStructure& structure, double time, Place place);

/// Divides rows (N x c) that are in residual standard deviations by L of a fit's correlation; rows
/// with independent residuals are not changed.
void whiten(const NonlinearModel& model,
            const VarianceEstimate& estimate,
            Eigen::Ref<MatrixXd> rows);

}  // namespace silvafit::fit
