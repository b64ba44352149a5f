// SPDX-License-Identifier: MIT
// Estimated marginal means of parameters at the levels of a factor.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// The mean of each parameter that depends on a factor at each of its levels: over all combinations
/// of the levels of other factors with equal weights, and at the means of numeric columns over the
/// rows of the fit. Named "a (species SM)".
/// \param table  of the fit
/// \throws UsageError if the column is no factor of the model, or there are too many combinations
/// Source: Searle, Speed and Milliken 1980, The American Statistician 34: 216-221.
std::vector<DerivedQuantity> marginal_means(const ModelSpecification& specification,
                                            const std::string& factor,
                                            const data::Table& table);

}  // namespace silvafit::fit
