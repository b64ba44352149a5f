// SPDX-License-Identifier: MIT
#include "optimum_search/exchanged_fits.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

#include "least_squares/exchanged_minima.hpp"
#include "mixed_effects/boundary.hpp"

namespace silvafit::fit {
namespace {

/// Replaces the random effects of the coefficients that differ between two fits.
void renew_effects(const NonlinearModel& model, const VectorXd& before, MixedEffectsFit& fit) {
  const VectorXd slopes = population_slopes(model, fit).sizes;
  const std::vector<RandomEffects>& terms = model.specification().random;
  for (std::size_t term = 0; term < terms.size(); ++term) {
    const std::vector<Index> places = model.coefficients_of(terms[term]);
    EstimatedEffects& random = fit.random[term];
    for (Index k = 0; k < random.covariance.rows(); ++k) {
      const Index place = places[static_cast<std::size_t>(k)];
      // Those with random effects only have no estimate.
      if (place >= before.size() || fit.estimate[place] == before[place]) continue;
      const double deviation = fit.residual_sd.mean() / slopes[place];
      random.covariance.row(k).setZero();
      random.covariance.col(k).setZero();
      random.covariance(k, k) = std::isfinite(deviation) ? deviation * deviation : 0.0;
      random.effects.row(k).setZero();
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

}  // namespace silvafit::fit
