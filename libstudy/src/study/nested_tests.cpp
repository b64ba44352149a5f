// SPDX-License-Identifier: MIT
#include "study/nested_tests.hpp"

#include <fmt/format.h>

#include "silvafit/base/error.hpp"

namespace silvafit::study {

std::optional<fit::NestedTest> nested_test(const fit::FittedModel& larger,
                                           const fit::FittedModel& smaller) {
  try {
    return fit::likelihood_ratio_test(larger, smaller);
  } catch (const UsageError&) {
    return std::nullopt;
  }
}

void add_random_effect_tests(std::vector<Candidate>& candidates, const fit::FittedModel& without) {
  for (Candidate& candidate : candidates) candidate.test = nested_test(candidate.fit, without);
}

std::string objection_to_likelihood(const fit::FittedModel& larger,
                                    const std::vector<SmallerModel>& smaller) {
  // Fits of a larger model that equals the smaller one end at the same point within this tolerance.
  constexpr double kSlack = 1e-3;
  for (const SmallerModel& each : smaller) {
    if (each.fit == &larger || larger.log_likelihood >= each.fit->log_likelihood - kSlack) continue;
    if (!nested_test(larger, *each.fit)) continue;
    return fmt::format(
        "Its log-likelihood ({:.2f}) is lower than that of the model {} ({:.2f}), which it "
        "contains.",
        larger.log_likelihood,
        each.name,
        each.fit->log_likelihood);
  }
  return "";
}

std::string objection_to_error(const fit::FittedModel& mixed,
                               const fit::FittedModel& least_squares) {
  constexpr double kRounding = 1e-6;
  constexpr double kWeights = 0.05;
  const double room = mixed.specification.variance.is_constant() ? kRounding : kWeights;
  const double limit = (1.0 + room) * least_squares.population.rmse;
  if (!mixed.has_random_effects() || !(mixed.conditional.rmse > limit)) return "";
  return fmt::format(
      "Its fitted values with random effects are farther from the observations (RMSE {:.3f}) than "
      "those of least squares ({:.3f}), so it is not at a maximum.",
      mixed.conditional.rmse,
      least_squares.population.rmse);
}

}  // namespace silvafit::study
