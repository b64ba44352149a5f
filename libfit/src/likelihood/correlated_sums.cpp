// SPDX-License-Identifier: MIT
#include "likelihood/correlated_sums.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace silvafit::fit {

CorrelatedSums::CorrelatedSums(const NonlinearModel& model,
                               const VarianceModel& variance,
                               const ObservationPoint& point,
                               std::vector<Index> random)
    : GroupSums(std::move(random)),
      linearizer_(model, variance),
      point_{.coefficients = point.beta,
             .effects = MatrixXd::Zero(point.beta.size(), model.group_count()),
             .variance = point.variance,
             .units = VectorXd::Ones(point.beta.size())},
      precision_(std::exp(-2.0 * point.log_sigma)) {
  holds_weights_ = true;
  for (Index j = 0; j < model.column_count(); ++j) {
    if (std::ranges::find(this->random(), j) == this->random().end()) others_.push_back(j);
  }
}

void CorrelatedSums::linearize(Index first,
                               Index last,
                               const MatrixXd& effects,
                               const Linearization& before) const {
  point_.first_group = first;
  point_.last_group = last;
  for (Index g = first; g < last; ++g) point_.effects(random(), g) = effects.col(g);
  // Where a sum is not finite, the search takes a shorter step.
  linearizer_.linearize(point_, false, &before, at_);
}

/// (p + 1 x p + 1) cross products, the last ones with the residuals plus the effects.
Eigen::Map<const MatrixXd> CorrelatedSums::products(Index group) const {
  const Index width = at_.model.moments.width();
  return {at_.model.moments.term(group, 0), width, width};
}

void CorrelatedSums::density(Index first,
                             Index last,
                             const MatrixXd& effects,
                             MatrixXd& sums,
                             Workspace& /*workspace*/,
                             HeldWeights* weights) const {
  Linearization before{.variance = point_.variance};
  if (at_.weight.size() > 0) before.weight = weights->held.array();
  linearize(first, last, effects, before);
  if (at_.weight.size() > 0) weights->own = at_.weight.matrix();
  const Index r = random_count();
  sums.resize(density_count(), last - first);
  for (Index g = first; g < last; ++g) {
    const MatrixXd curvature = precision_ * products(g)(random(), random());
    const VectorXd response = precision_ * products(g)(random(), point_.effects.rows());
    auto of = sums.col(g - first);
    of[0] = 0.5 * precision_ * at_.squares_before[g];
    of.segment(1, r) = curvature * effects.col(g) - response;
    for (Index column = 0, at = 1 + r; column < r; at += r - column, ++column) {
      of.segment(at, r - column) = curvature.col(column).tail(r - column);
    }
    of[of.size() - 1] = 0.5 * precision_ * at_.squares[g];
  }
}

void CorrelatedSums::mixed(Index first,
                           Index last,
                           const MatrixXd& effects,
                           MatrixXd& sums,
                           Workspace& /*workspace*/) const {
  linearize(first, last, effects, {.variance = point_.variance});
  sums.resize(std::ssize(others()) * random_count(), last - first);
  for (Index g = first; g < last; ++g) {
    const MatrixXd of = precision_ * products(g)(random(), others());
    sums.col(g - first) = of.reshaped();
  }
}

}  // namespace silvafit::fit
