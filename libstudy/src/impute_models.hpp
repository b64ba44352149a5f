// SPDX-License-Identifier: MIT
// The models that imputation tries, and which of them it takes.
#pragma once

#include "silvafit/study/impute.hpp"

namespace silvafit::study {

/// The model of some trees.
/// \param notes  gets what was tried in vain
/// \throws NumericalError if none converges
fit::FittedModel imputation_model(const data::Table& measured,
                                  const Catalogue& catalogue,
                                  const ImputeOptions& options,
                                  std::vector<std::string>& notes);

}  // namespace silvafit::study
