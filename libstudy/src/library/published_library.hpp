// SPDX-License-Identifier: MIT
// Published coefficients as a model library.
#pragma once

#include "silvafit/data/json_reader.hpp"
#include "silvafit/study/model_library.hpp"

namespace silvafit::study {

/// The models of a file of published coefficients, schema silvafit-published-models/1: levels base,
/// covariates and mixed get the roles ols, covariates and nlme. Values that a source does not print
/// (standard errors, EBLUPs, parameters of variance functions) is NaN.
/// \throws InputError that names file and key where an entry cannot be used
ModelLibrary published_library(const data::JsonReader& document);

}  // namespace silvafit::study
