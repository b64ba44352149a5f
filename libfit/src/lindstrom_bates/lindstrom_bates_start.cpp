// SPDX-License-Identifier: MIT
// The state of the alternation of Lindstrom and Bates at a given fit.
#include <Eigen/QR>

#include "lindstrom_bates/lindstrom_bates.hpp"
#include "result/nested_effects.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Directions of L that are smaller by this factor contain no significant random effects.
constexpr double kSmallestPivot = 1e-6;

/// The spherical effects v of effects b = L v, as far as L can represent them.
MatrixXd spherical_of(const MatrixXd& factor, const MatrixXd& effects) {
  if (factor.size() == 0) return effects;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  solver.setThreshold(kSmallestPivot);
  solver.compute(factor);
  return solver.solve(effects);
}

}  // namespace

LindstromBatesState LindstromBates::start_at(const MixedEffectsFit& fit) {
  adopt_units(pooled_.scale, pooled_.mixing);
  const VectorXd parameters = variance_.inside_range(fit.variance);
  const double sigma = fit.sigma / variance_.sigma_factor(parameters);
  LindstromBatesState state{
      .scale = scale_, .mixing = mixing_, .beta = scaled_values(all_, fit.estimate)};
  const auto relative = [&](const MatrixXd& covariance, const std::vector<Index>& which) {
    const MatrixXd half = scaled_values(which, covariance);
    return MatrixXd(scaled_values(which, half.transpose()) / (sigma * sigma));
  };
  state.theta.resize(random_parameter_count() + parameters.size());
  state.theta << inner_factor_.from_covariance(relative(finer(fit).covariance, random_)),
      outer_factor_.from_covariance(relative(coarser(fit).covariance, outer_random_)), parameters;
  const RelativeFactors now = factors(state.theta);
  state.spherical = random_.empty()
                        ? MatrixXd::Zero(0, model_.group_count())
                        : spherical_of(now.inner, scaled_values(random_, finer(fit).effects));
  state.outer_spherical =
      outer_random_.empty()
          ? MatrixXd::Zero(0, 0)
          : spherical_of(now.outer, scaled_values(outer_random_, coarser(fit).effects));
  return state;
}

}  // namespace silvafit::fit
