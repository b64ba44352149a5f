// SPDX-License-Identifier: MIT
// Formulas of R's lm and lme4 in the form of silvafit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/formula_parts.hpp"

namespace silvafit::fit {

/// Bar terms as random effects of coefficients, such as "a + b | plot" for (dbh | plot) and the
/// mean a + b*dbh: each effect belongs to the parameter whose derivative it is.
/// \param mean        the right side without the bar terms
/// \param parameters  names of the mean that are not columns
/// \return  no value if an effect is not that of exactly one parameter
std::optional<std::string> random_text_of(const std::vector<BarTerm>& bars,
                                          const data::Expression& mean,
                                          const std::vector<std::string>& parameters,
                                          const data::Table& table);

/// The message about a formula of columns only, such as h ~ age + (1 | plot): what to write here.
std::string without_parameters(const data::Formula& formula,
                               const std::vector<BarTerm>& bars,
                               const data::Table& table);

/// The message about bar terms that are not the effects of coefficients.
std::string unclear_bars(const std::vector<BarTerm>& bars,
                         const std::vector<std::string>& parameters);

}  // namespace silvafit::fit
