// SPDX-License-Identifier: MIT
// Wald tests of the terms of sub-models.
#pragma once

#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// The test that all coefficients of a term are 0, given all other terms.
struct TermTest {
  std::string term{};  ///< "b", "b:C"; of a factor without its levels, "b:species"
  int numerator_df = 0;
  double denominator_df = 0.0;  ///< the smallest of the coefficients
  double f = 0.0;               ///< b' V^-1 b / numerator_df
  double p = 0.0;
};

/// Tests of all terms in the order of the coefficients. Coefficients without a standard error, such
/// as those that are held at a value, are not tested. NaN if the degrees of freedom are not known.
std::vector<TermTest> term_tests(const FittedModel& fit);

}  // namespace silvafit::fit
