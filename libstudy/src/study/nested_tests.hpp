// SPDX-License-Identifier: MIT
// Likelihood-ratio tests between the models of a study.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// The test of a larger model against one that it contains. Variances of zero are at their
/// bound, so that the reference may be a mixture of chi-squared distributions and p smaller
/// than by chi-squared alone. Empty if there is no such test: fits that failed, are not
/// nested, or are to other rows.
std::optional<fit::NestedTest> nested_test(const fit::FittedModel& larger,
                                           const fit::FittedModel& smaller);

/// Tests each mixed model against the one without random effects.
void add_random_effect_tests(std::vector<Candidate>& candidates, const fit::FittedModel& without);

/// A model that a larger one may contain, and its description: "without random effects".
struct SmallerModel {
  std::string name{};
  const fit::FittedModel* fit = nullptr;
};

/// The objection to a model that is less likely than one that it contains, as a sentence; empty
/// if there is none.
std::string objection_to_likelihood(const fit::FittedModel& larger,
                                    const std::vector<SmallerModel>& smaller);

/// The objection to a mixed model whose fitted values with random effects are farther from the
/// observations than those of least squares, as a sentence; empty if they are not. At a maximum
/// they are nearer: coefficients and random effects minimize the squares with a penalty for the
/// random effects, and least squares is one of the feasible points. Variance functions weight
/// the squares, so a small tolerance is needed.
std::string objection_to_error(const fit::FittedModel& mixed,
                               const fit::FittedModel& least_squares);

}  // namespace silvafit::study
