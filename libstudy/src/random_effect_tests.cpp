// SPDX-License-Identifier: MIT
#include "random_effect_tests.hpp"

#include "silvafit/base/error.hpp"
#include "silvafit/fit/likelihood_ratio.hpp"

namespace silvafit::study {

void add_random_effect_tests(std::vector<Candidate>& candidates, const fit::FittedModel& without) {
  for (Candidate& candidate : candidates) {
    try {
      const fit::NestedTest test = fit::likelihood_ratio_test(candidate.fit, without);
      candidate.test = {
          .statistic = test.statistic, .degrees_of_freedom = test.degrees_of_freedom, .p = test.p};
    } catch (const UsageError&) {
      candidate.test.reset();
    }
  }
}

}  // namespace silvafit::study
