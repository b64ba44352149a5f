// SPDX-License-Identifier: MIT
// The estimated terms of a model: one grouping, or two nested ones.
#pragma once

#include "silvafit/fit/estimates.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The estimates of the only or the finer grouping; empty ones without random effects.
const EstimatedEffects& finer(const Estimates& estimates);
/// The estimates of the coarser of two nested groupings; empty ones without it.
const EstimatedEffects& coarser(const Estimates& estimates);

/// Sets names and labels of a model's terms. Values are unchanged.
void name_terms(const NonlinearModel& model, Estimates& estimates);
/// The terms of a model with missing values.
std::vector<EstimatedEffects> missing_terms(const NonlinearModel& model);

}  // namespace silvafit::fit
