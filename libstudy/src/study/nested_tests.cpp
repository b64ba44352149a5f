// SPDX-License-Identifier: MIT
#include "study/nested_tests.hpp"

#include "silvafit/base/error.hpp"
#include "silvafit/fit/likelihood_ratio.hpp"

namespace silvafit::study {

std::optional<LikelihoodRatioTest> nested_test(const fit::FittedModel& larger,
                                               const fit::FittedModel& smaller) {
  try {
    const fit::NestedTest test = fit::likelihood_ratio_test(larger, smaller);
    return LikelihoodRatioTest{
        .statistic = test.statistic, .degrees_of_freedom = test.degrees_of_freedom, .p = test.p};
  } catch (const UsageError&) {
    return std::nullopt;
  }
}

void add_random_effect_tests(std::vector<Candidate>& candidates, const fit::FittedModel& without) {
  for (Candidate& candidate : candidates) candidate.test = nested_test(candidate.fit, without);
}

}  // namespace silvafit::study
