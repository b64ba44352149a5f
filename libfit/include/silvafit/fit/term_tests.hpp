// SPDX-License-Identifier: MIT
// Wald tests of the terms of sub-models.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// What a term is tested given.
enum class TermOrder {
  kMarginal,    ///< all other terms
  kSequential,  ///< the terms before it, in the order of the coefficients
};

/// The test that all coefficients of a term are 0.
struct TermTest {
  std::string term{};  ///< "b", "b:C"; of a factor without its levels, "b:species"
  int numerator_df = 0;
  double denominator_df = 0.0;  ///< the smallest of the coefficients
  double f = 0.0;               ///< b' V^-1 b / numerator_df
  double p = 0.0;
};

/// Wald's tests of all terms in the order of the coefficients. Coefficients without a standard
/// error, such as those that are held at a value, are not tested. NaN if the degrees of freedom are
/// not known.
/// Source: Pinheiro and Bates 2000, section 2.4.2; R nlme's anova.lme().
std::vector<TermTest> term_tests(const FittedModel& fit, TermOrder order = TermOrder::kMarginal);

/// The test that several terms are 0, given by their places in term_tests(); named "combined".
/// \throws UsageError if there is no such term
TermTest joint_test(const FittedModel& fit, const std::vector<std::size_t>& terms);

/// The test that linear combinations of coefficients are 0, or have the given values.
/// \param combinations  (combinations x coefficients)
/// \param values        (combinations), or none
/// \throws UsageError if one contains a coefficient without a standard error, follows from others
///         or contradicts them
TermTest joint_test(const FittedModel& fit,
                    const Eigen::MatrixXd& combinations,
                    const Eigen::VectorXd& values = {});

}  // namespace silvafit::fit
