// SPDX-License-Identifier: MIT
#include "optimum_search/exchanged_fits.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>

#include "least_squares/exchanged_minima.hpp"
#include "least_squares/periodic_coefficients.hpp"
#include "mixed_effects/boundary.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Replaces the random effects of the coefficients that differ between two fits.
void renew_effects(const NonlinearModel& model, const VectorXd& before, MixedEffectsFit& fit) {
  const VectorXd slopes = population_slopes(model, fit).sizes;
  const std::vector<RandomEffects>& terms = model.specification().random;
  for (std::size_t term = 0; term < terms.size(); ++term) {
    const std::vector<Index> places = model.coefficients_of(&terms[term]);
    EstimatedEffects& random = fit.random[term];
    for (Index k = 0; k < random.covariance.rows(); ++k) {
      const Index place = places[static_cast<std::size_t>(k)];
      if (fit.estimate[place] == before[place]) continue;
      const double deviation = fit.residual_sd.mean() / slopes[place];
      random.covariance.row(k).setZero();
      random.covariance.col(k).setZero();
      random.covariance(k, k) = std::isfinite(deviation) ? deviation * deviation : 0.0;
      random.effects.row(k).setZero();
    }
  }
}

/// The groups whose phases are far from the common one, the farthest first.
std::vector<Index> farthest(const VectorXd& angles, double period) {
  // Shifts of other groups make the distribution of the effects wider.
  constexpr double kFar = 0.125;
  constexpr std::size_t kMostGroups = 4;
  std::vector<Index> groups;
  for (Index g = 0; g < angles.size(); ++g) {
    if (std::abs(angles[g]) > kFar * period) groups.push_back(g);
  }
  std::ranges::sort(groups, std::ranges::greater(), [&](Index g) { return std::abs(angles[g]); });
  groups.resize(std::min(groups.size(), kMostGroups));
  return groups;
}

/// Adds the fits with the group's phase shifted by half a period and by a whole one, as far as its
/// curve remains the same.
void add_shifted(const NonlinearModel& model,
                 const MixedEffectsFit& fit,
                 std::size_t term,
                 Index group,
                 const PhaseCoefficient& phase,
                 std::vector<MixedEffectsFit>& result) {
  const std::vector<Index> places = model.coefficients_of(&model.specification().random[term]);
  VectorXd own = fit.estimate;
  own(places) += fit.random[term].effects.col(group);
  const double direction = own[phase.coefficient] > fit.estimate[phase.coefficient] ? -1.0 : 1.0;
  for (const double half_periods : {direction, 2.0 * direction}) {
    for (const Exchange& exchange : phase_shifts(model, own, phase, half_periods)) {
      const VectorXd change = exchange.of(own) - own;
      VectorXd without = change;
      without(places).setZero();
      // A coefficient without random effects is that of all groups.
      if (!without.isZero(0.0)) continue;
      result.push_back(fit);
      result.back().random[term].effects.col(group) += change(places);
    }
  }
}

}  // namespace

std::vector<MixedEffectsFit> exchanged_fits(const NonlinearModel& model,
                                            const MixedEffectsFit& fit) {
  std::vector<MixedEffectsFit> result;
  for (VectorXd& coefficients : exchanged_minima(model, fit.estimate)) {
    MixedEffectsFit other = fit;
    other.estimate = std::move(coefficients);
    renew_effects(model, fit.estimate, other);
    result.push_back(std::move(other));
  }
  return result;
}

std::vector<MixedEffectsFit> shifted_fits(const NonlinearModel& model, const MixedEffectsFit& fit) {
  std::vector<MixedEffectsFit> result;
  const std::vector<RandomEffects>& terms = model.specification().random;
  for (const PhaseCoefficient& phase : phase_coefficients(model, fit.estimate)) {
    for (std::size_t term = 0; term < terms.size(); ++term) {
      const std::vector<Index> places = model.coefficients_of(&terms[term]);
      const auto place = std::ranges::find(places, phase.coefficient);
      if (place == places.end()) continue;
      const VectorXd angles = fit.random[term].effects.row(place - places.begin());
      for (const Index group : farthest(angles, phase.period)) {
        add_shifted(model, fit, term, group, phase, result);
      }
    }
  }
  return result;
}

}  // namespace silvafit::fit
