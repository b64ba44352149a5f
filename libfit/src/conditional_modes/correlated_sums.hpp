// SPDX-License-Identifier: MIT
// Sums over the rows of each group of a model whose residuals are correlated.
#pragma once

#include <vector>

#include "conditional_modes/observation_sums.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The sums of ObservationTerms of correlated rows, with those between rows. A value that is not
/// finite, or a correlation that is singular, makes a group's density NaN.
class CorrelatedSums : public GroupSums {
 public:
  /// \param variance  with the correlation; outlives this object, as the model does
  CorrelatedSums(const NonlinearModel& model,
                 const VarianceModel& variance,
                 Curvature curvature,
                 const ObservationTerms& terms,
                 const std::vector<Index>& random,
                 bool with_slopes);

  void set_point(const ObservationPoint& point) override;
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
  void slopes(Index first,
              Index last,
              const MatrixXd& effects,
              MatrixXd& sums,
              Workspace& workspace) const override;
  void total(Index first,
             Index last,
             const MatrixXd& effects,
             const MatrixXd& weights,
             MatrixXd& sums,
             Workspace& workspace) const override;

 private:
  template <typename Use>
  void for_blocks(Index first, Index last, const Use& use) const;
  void hold_residuals(Index first, Index last, Workspace& workspace) const;
  void hold_penalties(const MatrixXd& weights, Index first, Index last, Workspace& workspace) const;
  void spread(const MatrixXd& from, Index source, Index numbers, MatrixXd& to, Index target) const;
  void add_between(const CorrelationFactor& factor,
                   const MatrixXd& states,
                   const MatrixXd& weight,
                   Eigen::Ref<VectorXd> sums) const;
  double penalty_slope(const CorrelationFactor& factor,
                       Index k,
                       const MatrixXd& states,
                       const MatrixXd& white,
                       const MatrixXd& slope,
                       const MatrixXd& weight) const;
  /// Places of columns among the states.
  Index means() const { return 1 + random_count(); }
  Index scales() const { return 1 + 2 * random_count(); }
  Index others_at() const { return 1 + (has_approximation_ ? 3 : 1) * random_count(); }
  Index variance_at() const { return others_at() + std::ssize(others_); }

  const VarianceModel& variance_;
  bool is_full_;       ///< K is the second derivative of rho
  Index scale_count_;  ///< parameters of the scale, with log sigma
  ObservationRows rows_;
  TermTasks tasks_;
  ObservationRows::Task states_;
  ObservationRows::Task wide_states_;
  CorrelatedRows::Factors factors_;  ///< empty if one is singular
};

}  // namespace silvafit::fit
