// SPDX-License-Identifier: MIT
#include "optimum_search/exchanged_fits.hpp"

#include <cmath>
#include <cstddef>

#include "least_squares/exchanged_minima.hpp"
#include "mixed_effects/boundary.hpp"

namespace silvafit::fit {
namespace {

/// Replaces the random effects of the coefficients that differ between two fits.
void renew_effects(const NonlinearModel& model, const VectorXd& before, MixedEffectsFit& fit) {
  const std::vector<RandomEffects>& terms = model.specification().random;
  if (terms.empty()) return;
  const VectorXd slopes = population_slopes(model, fit).sizes;
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

MixedEffectsFit exchanged_fit(const NonlinearModel& model,
                              const MixedEffectsFit& fit,
                              const VectorXd& coefficients) {
  MixedEffectsFit result = fit;
  result.estimate = coefficients;
  renew_effects(model, fit.estimate, result);
  return result;
}

std::vector<MixedEffectsFit> exchanged_fits(const NonlinearModel& model,
                                            const MixedEffectsFit& fit) {
  std::vector<MixedEffectsFit> result;
  for (const VectorXd& coefficients : exchanged_minima(model, fit.estimate)) {
    result.push_back(exchanged_fit(model, fit, coefficients));
  }
  return result;
}

}  // namespace silvafit::fit
