// SPDX-License-Identifier: MIT
// Sums over the groups of a model whose residuals are correlated: those of penalized least squares.
#pragma once

#include <vector>

#include "conditional_modes/observation_sums.hpp"
#include "likelihood/linearization.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The squares of the rows of each group over two, whitened by the correlation and with held
/// weights, and their derivatives in the model linear around the effects: those of lb. One caller
/// at a time.
class CorrelatedSums : public GroupSums {
 public:
  /// \param variance  with the correlation; outlives this object, as the model does
  /// \param random    coefficients with random effects in any grouping, ascending
  CorrelatedSums(const NonlinearModel& model,
                 const VarianceModel& variance,
                 const ObservationPoint& point,
                 std::vector<Index> random);

  void density(Index first,
               Index last,
               const MatrixXd& effects,
               MatrixXd& sums,
               Workspace& workspace,
               HeldWeights* weights) const override;
  void mixed(Index first,
             Index last,
             const MatrixXd& effects,
             MatrixXd& sums,
             Workspace& workspace) const override;

 private:
  void linearize(Index first,
                 Index last,
                 const MatrixXd& effects,
                 const Linearization& before) const;
  Eigen::Map<const MatrixXd> products(Index group) const;

  mutable Linearizer linearizer_;
  mutable LinearizationPoint point_;
  mutable Linearization at_;
  double precision_ = 1.0;
};

}  // namespace silvafit::fit
