// SPDX-License-Identifier: MIT
// Comparison of fixed points with the fits of smaller random structures.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "marginal_likelihood/marginal_fit.hpp"
#include "optimum_search/fixed_points.hpp"

namespace silvafit::fit {

using Eigen::VectorXd;

void FixedPoints::add_without_random_effects(std::vector<ContainedModel>& contained) const {
  const NonlinearModel fixed = model_.with_random_effects({});
  // A restricted likelihood is not comparable with the marginal one of the whole model.
  MixedEffectsOptions options = linearized_;
  options.reml = false;
  const LindstromBatesSearch found =
      climb_lindstrom_bates(fixed, first_coefficients(), options, Persistence::kOnce);
  if (!found.outcome.is_valid || !found.outcome.converged) return;
  contained.push_back({.text = "without random effects",
                       .log_likelihood = found.outcome.log_likelihood,
                       .rank = found.outcome.log_likelihood});
}

/// Fits with a smaller random structure. The whole model starts from those with a higher
/// likelihood, and from those that were not started from its own fit.
void FixedPoints::compare_with_smaller() {
  add_without_random_effects(contained_);
  for (const SmallerStructure& smaller : structures_to_compare()) {
    if (budget_.is_spent()) break;
    const MixedEffectsFit best = best_of(candidates_).fit;
    for (const MixedEffectsFit& found : smaller_fits(smaller, best)) {
      if (is_higher(found, best)) {
        contained_.push_back(
            {.text = smaller.text,
             .log_likelihood = found.log_likelihood,
             .rank = marginal_log_likelihood(smaller.model, found, ranking_, options_.marginal)});
      }
      go_on_from_smaller(smaller, found);
    }
  }
}

void FixedPoints::go_on_from_smaller(const SmallerStructure& smaller,
                                     const MixedEffectsFit& found) {
  auto again =
      fixed_point_from(model_, enlarged(found, smaller, small_deviation(model_, smaller, found)));
  const std::string origin = "the fit " + smaller.text;
  const std::size_t known = candidates_.size();
  if (again) add_candidate(candidates_, {.fit = *std::move(again), .origin = origin});
  linearize_from({.coefficients = found.estimate, .origin = origin}, Persistence::kOnce);
  if (candidates_.size() > known) rank();
}

std::vector<SmallerStructure> FixedPoints::structures_to_compare() const {
  return is_settled() ? std::vector<SmallerStructure>() : smaller_structures(model_);
}

/// The fit of a smaller structure that starts from the whole model's fit, if it is higher, and the
/// one from the pooled coefficients, if it differs.
std::vector<MixedEffectsFit> FixedPoints::smaller_fits(const SmallerStructure& smaller,
                                                       const MixedEffectsFit& whole) {
  std::vector<MixedEffectsFit> result;
  const auto near = fixed_point_from(smaller.model, reduced(whole, smaller));
  if (near && is_higher(*near, whole)) result.push_back(*near);
  if (smaller.left_out < 0) return result;
  const LindstromBatesSearch own =
      climb_lindstrom_bates(smaller.model, first_coefficients(), linearized_, Persistence::kOnce);
  budget_.spend_work(own.work);
  if (!own.outcome.is_valid || !own.outcome.converged) return result;
  MixedEffectsFit fit = own.engine->result(own.outcome);
  if (result.empty() || !is_same(*near, fit)) result.push_back(std::move(fit));
  return result;
}

const VectorXd& FixedPoints::first_coefficients() const {
  return from_part_.size() > 0 ? from_part_ : pooled_.estimate;
}

}  // namespace silvafit::fit
