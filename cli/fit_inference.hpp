// SPDX-License-Identifier: MIT
// Intervals of `silvafit fit`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::cli {

struct InferenceOptions {
  std::string intervals{};  ///< wald, profile, or empty
  double level = 0.95;
  unsigned threads = 1;
};

void add_inference_options(CLI::App& command, InferenceOptions& options);

/// Computes the requested intervals of a fit; none if it has not converged.
void add_inference(const InferenceOptions& options,
                   const data::Table& table,
                   fit::FittedModel& fit);

}  // namespace silvafit::cli
