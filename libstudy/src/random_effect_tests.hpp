// SPDX-License-Identifier: MIT
// Likelihood-ratio tests of the random effects that a study tries.
#pragma once

#include <vector>

#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// Tests each mixed model against the one without random effects. Variances of zero lie on the edge
/// of their range, so that the reference is a mixture of chi-squared distributions and p is smaller
/// than by chi-squared alone. Fits that failed, or are to other rows, get no test.
void add_random_effect_tests(std::vector<Candidate>& candidates, const fit::FittedModel& without);

}  // namespace silvafit::study
