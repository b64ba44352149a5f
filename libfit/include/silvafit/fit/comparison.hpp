// SPDX-License-Identifier: MIT
// Comparison of fits: information criteria, and tests of each against the next.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/likelihood_ratio.hpp"

namespace silvafit::fit {

/// A row of a comparison. Both values are NaN if the number of parameters is not known, as for some
/// published models; the others are compared among themselves.
struct ComparedFit {
  const FittedModel* fit = nullptr;
  double aic_difference = 0.0;  ///< to the smallest
  double akaike_weight = 0.0;   ///< exp(-difference/2), normalized to the sum one
};

/// The test of a fit against one before it in the comparison, or the reason why there is none.
struct ComparedPair {
  std::size_t larger = 0;  ///< rows of the comparison
  std::size_t smaller = 0;
  std::optional<NestedTest> test{};
  std::string reason{};
};

struct Comparison {
  /// Converged fits, by number of parameters; those with an unknown number are last.
  std::vector<ComparedFit> fits{};
  std::vector<ComparedPair> pairs{};  ///< of neighbors
  /// The reason why criteria are not comparable (other observations, other methods, other fixed
  /// effects with restricted likelihood), or empty. Differences and weights are then NaN.
  std::string reason{};
  std::vector<const FittedModel*> failed{};  ///< that did not converge
};

/// Compares fits by AIC and, from the fewest parameters on, each with the next.
/// \param fits  must outlive the comparison
/// \throws UsageError for fewer than two fits
Comparison compare(const std::vector<const FittedModel*>& fits);

}  // namespace silvafit::fit
