// SPDX-License-Identifier: MIT
// Coefficients that are held at a value instead of being estimated.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// The message on a name that is none of the known coefficients; a column of the formula is pointed
/// out.
std::string no_such_coefficient(const ModelSpecification& specification,
                                std::string_view name,
                                const std::vector<std::string>& known);

/// \throws UsageError if this is not a coefficient
void check_known(const ModelSpecification& specification, const std::string& name);

/// Whether a coefficient has random effects in any term.
bool has_effects(const ModelSpecification& specification, const std::string& name);

/// A model with some coefficients replaced by numbers in its formula. Random effects of these are
/// deviations from the numbers: ParameterModel::random_only.
/// \param held  values by coefficient
/// \throws UsageError as check_known, or if a value is not finite
ModelSpecification with_constants(const ModelSpecification& specification,
                                  const std::map<std::string, double>& held);

/// The same, if at least one coefficient or random effect is left to estimate.
/// \throws UsageError as with_constants, or if none is left
ModelSpecification with_held(const ModelSpecification& specification,
                             const std::map<std::string, double>& held);

}  // namespace silvafit::fit
