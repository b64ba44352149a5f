// SPDX-License-Identifier: MIT
// Likelihood-ratio tests between the models of a study.
#pragma once

#include <optional>
#include <vector>

#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// The test of a larger model against one that it contains. Variances of zero lie on the edge of
/// their range, so that the reference may be a mixture of chi-squared distributions and p smaller
/// than by chi-squared alone. Nothing where there is no such test: fits that failed, are not
/// nested, or are to other rows.
std::optional<LikelihoodRatioTest> nested_test(const fit::FittedModel& larger,
                                               const fit::FittedModel& smaller);

/// Tests each mixed model against the one without random effects.
void add_random_effect_tests(std::vector<Candidate>& candidates, const fit::FittedModel& without);

}  // namespace silvafit::study
