// SPDX-License-Identifier: MIT
// The state of the alternation of Lindstrom and Bates at a given fit.
#include "lindstrom_bates/lindstrom_bates.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

LindstromBatesState LindstromBates::start_at(const MixedEffectsFit& fit) {
  adopt_units(pooled_.scale, pooled_.mixing);
  const VectorXd parameters = variance_.inside_range(fit.variance);
  const double sigma = fit.sigma / variance_.sigma_factor(parameters);
  LindstromBatesState state{
      .scale = scale_, .mixing = mixing_, .beta = scaled_values(all_, fit.estimate)};
  state.theta.resize(random_parameter_count() + parameters.size());
  for_each_term([&](std::size_t t, const RelativeFactor& factor, Index begin) {
    const MatrixXd half = scaled_values(random_[t], fit.random[t].covariance);
    const MatrixXd relative = scaled_values(random_[t], half.transpose()) / (sigma * sigma);
    state.theta.segment(begin, factor.parameter_count()) = factor.from_covariance(relative);
  });
  state.theta.tail(parameters.size()) = parameters;
  const RelativeFactors now = factors(state.theta);
  for (std::size_t t = 0; t < now.size(); ++t) {
    state.spherical.push_back(
        spherical_effects(now[t], scaled_values(random_[t], fit.random[t].effects)));
  }
  if (!fit.variance.correlation) choose_correlation(state);
  return state;
}

}  // namespace silvafit::fit
