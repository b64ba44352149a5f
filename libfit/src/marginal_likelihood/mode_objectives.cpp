// SPDX-License-Identifier: MIT
#include "marginal_likelihood/mode_objectives.hpp"

#include <cmath>

#include "model/group_coefficients.hpp"
#include "model/variance_weights.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// (p x G) the coefficients of each group.
MatrixXd coefficients_at(const NonlinearModel& model,
                         const RandomPlaces& places,
                         const MarginalPoint& point,
                         const Modes& modes) {
  MatrixXd result = point.observation.beta.replicate(1, model.group_count());
  const MatrixXd inner = point.inner_factor * modes.inner;
  const MatrixXd outer = point.outer_factor * modes.outer;
  add_group_effects(model,
                    {.rows = places.inner, .effects = inner},
                    {.rows = places.outer, .effects = outer},
                    result);
  return result;
}

}  // namespace

VectorXd mode_objectives(const NonlinearModel& model,
                         const VarianceModel& variance,
                         const RandomPlaces& places,
                         const MarginalPoint& point,
                         const Modes& modes) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  model.evaluate(coefficients_at(model, places, point, modes), mean, nullptr, workspace);
  const ResidualScale residual = variance.scale(mean, point.observation.variance, false);
  const double precision = std::exp(-2.0 * point.observation.log_sigma);
  const Eigen::ArrayXd squares = (model.response() - mean).array().square() * precision;
  const Eigen::ArrayXd terms = 0.5 * (squares * residual.weight - residual.weight.log());
  VectorXd result(model.cluster_count());
  for (Index c = 0; c < result.size(); ++c) {
    const Index first = model.cluster_begin(c);
    const Index last = model.cluster_begin(c + 1);
    const Index begin = model.group_begin(first);
    result[c] = terms.segment(begin, model.group_begin(last) - begin).sum() +
                0.5 * modes.inner.middleCols(first, last - first).squaredNorm();
    if (modes.outer.rows() > 0) result[c] += 0.5 * modes.outer.col(c).squaredNorm();
  }
  return result;
}

bool take_lower(const NonlinearModel& model,
                const Modes& others,
                const VectorXd& of_others,
                Modes& modes,
                VectorXd& objectives) {
  constexpr double kLower = 1e-6;
  bool any = false;
  for (Index c = 0; c < objectives.size(); ++c) {
    if (!(of_others[c] < objectives[c] - kLower)) continue;
    const Index first = model.cluster_begin(c);
    const Index count = model.cluster_begin(c + 1) - first;
    modes.inner.middleCols(first, count) = others.inner.middleCols(first, count);
    if (modes.outer.rows() > 0) modes.outer.col(c) = others.outer.col(c);
    objectives[c] = of_others[c];
    any = true;
  }
  return any;
}

std::vector<Modes> other_starts(const Modes& modes) {
  const Modes none{.outer = MatrixXd::Zero(modes.outer.rows(), modes.outer.cols()),
                   .inner = MatrixXd::Zero(modes.inner.rows(), modes.inner.cols())};
  std::vector<Modes> starts{none};
  constexpr double kFar = 2.0;  // standard deviations
  for (const double side : {kFar, -kFar}) {
    for (Index k = 0; k < modes.inner.rows(); ++k) {
      starts.push_back(none);
      starts.back().inner.row(k).setConstant(side);
    }
    for (Index k = 0; k < modes.outer.rows(); ++k) {
      starts.push_back(none);
      starts.back().outer.row(k).setConstant(side);
    }
  }
  return starts;
}

}  // namespace silvafit::fit
