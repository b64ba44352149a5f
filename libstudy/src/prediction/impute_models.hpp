// SPDX-License-Identifier: MIT
// The models that imputation tries, and its choice among them.
#pragma once

#include "silvafit/study/impute.hpp"

namespace silvafit::study {

/// The column of the plots: the requested one, or `plot`; empty if the table has none.
std::string plot_column(const data::Table& table, const ImputeOptions& options);

/// Checks that the columns which the models read as numbers contain numbers.
/// \throws InputError at the first value that is no number, or if there is no such column
void require_model_numbers(const data::Table& table,
                           const Catalogue& catalogue,
                           const ImputeOptions& options);

/// The model of some trees.
/// \param notes  receives the models that failed, and why there are no random effects
/// \throws NumericalError if none converges
fit::FittedModel imputation_model(const data::Table& measured,
                                  const Catalogue& catalogue,
                                  const ImputeOptions& options,
                                  std::vector<std::string>& notes);

}  // namespace silvafit::study
