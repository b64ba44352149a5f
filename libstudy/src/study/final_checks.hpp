// SPDX-License-Identifier: MIT
// Checks of the final model of a species and response.
#pragma once

#include "silvafit/data/table.hpp"
#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// Adds doubts about a model that explains nothing, or whose residual variance is that of a few
/// trees, and notes on outlying trees and plots, and on neighbors whose residuals are alike.
/// \param table  the inventory, of which the result has rows
void check_final_model(ResponseStudy& result, const data::Table& table);

}  // namespace silvafit::study
