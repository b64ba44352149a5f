// SPDX-License-Identifier: MIT
// Bootstrap, cross-validation and residuals of `silvafit fit`.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/bootstrap.hpp"
#include "silvafit/fit/cross_validation.hpp"

namespace silvafit::cli {

struct ResamplingArguments {
  fit::BootstrapOptions bootstrap{.replicates = 0};  ///< 0: none; `group` is that of both
  fit::CrossValidationOptions cross_validation{};
  bool cross_validates = false;
  std::string residuals{};  ///< file
};

void add_resampling_options(CLI::App& command, ResamplingArguments& arguments);

/// The requested results for one fit; none for a fit that failed.
struct Resampling {
  std::optional<fit::Bootstrap> bootstrap{};
  std::optional<fit::CrossValidation> cross_validation{};
};

/// \param options  how each model was fitted
std::vector<Resampling> resample(const std::vector<fit::FittedModel>& fits,
                                 const std::vector<fit::FitModelOptions>& options,
                                 const data::Table& table,
                                 const ResamplingArguments& arguments,
                                 const CommonOptions& common);

/// Writes the residuals of the only fit, if requested.
void write_residuals(const std::vector<fit::FittedModel>& fits,
                     const data::Table& table,
                     const ResamplingArguments& arguments);

/// The JSON of a fit, with the keys `bootstrap`, `cross_validation` and `recognized` if they have
/// content.
/// \param recognized  the notes on how the file was read
std::string with_resampling(const std::string& fit_json,
                            const Resampling& resampling,
                            const std::vector<std::string>& recognized);

/// Prints the results as text tables.
void print_resampling(const std::vector<fit::FittedModel>& fits,
                      const std::vector<Resampling>& resampling);

}  // namespace silvafit::cli
