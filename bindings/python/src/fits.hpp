// SPDX-License-Identifier: MIT
// Fits: their computation, content and derived results.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::python {

using FitPointer = std::shared_ptr<fit::FittedModel>;

/// A fit for Python, which nobody changes any more.
inline FitPointer share(fit::FittedModel fit) {
  return std::make_shared<fit::FittedModel>(std::move(fit));
}

class Arguments;

/// How to fit, by the arguments of fit() that nobody took yet.
/// \throws UsageError for an unknown name or method, or a value of the wrong type
fit::FitModelOptions fit_options(Arguments& arguments);

/// r2, mean_error, rmse and mae.
pybind11::dict statistics_of(const fit::FitStatistics& statistics);

/// The class Fit with its values, JSON, and fit().
void add_fits(pybind11::module_& module);
/// Predictions, residuals and simulated responses.
void add_predictions(pybind11::module_& module);
/// Intervals, comparisons, the bootstrap and cross-validation.
void add_inference(pybind11::module_& module);

}  // namespace silvafit::python
