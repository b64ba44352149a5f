// SPDX-License-Identifier: MIT
// Random effects inside a formula, as R's lme4 writes them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace silvafit::fit {

/// The term `(effects | group)` of a formula, or `(effects || group)` with uncorrelated effects.
struct BarTerm {
  std::string text{};     ///< "(1 + dbh | plot)"
  std::string effects{};  ///< "1 + dbh"
  std::string group{};    ///< "plot", "stand/plot", "stand:plot"
  bool is_uncorrelated = false;

  /// The columns of the group.
  std::vector<std::string> group_columns() const;
};

/// A formula without its random effects, and these.
struct FormulaParts {
  std::string fixed{};
  std::vector<BarTerm> bars{};
};

/// Separates the bar terms, which are summands of the right side, from a formula. The rest is not
/// read.
/// \throws FormulaError if a bar is not inside parentheses, as in `h ~ a + b*dbh | plot`
FormulaParts split_formula(std::string_view formula);

}  // namespace silvafit::fit
