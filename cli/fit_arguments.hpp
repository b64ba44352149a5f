// SPDX-License-Identifier: MIT
// The arguments of `silvafit fit`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "fit_inference.hpp"
#include "fit_resampling.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {

struct FitArguments {
  CommonOptions common{};
  TableArguments table{};
  std::string data{};
  std::string formula{};
  std::vector<std::string> models{};
  std::vector<std::string> parameters{};
  std::string random{};
  std::string covariance{};
  std::string variance{};
  std::string method{};
  int quadrature_points = 7;
  bool reml = false;
  bool trace = false;
  bool shares_groups = false;
  std::string where{};
  std::string start{};
  int spread_starts = 0;
  std::string fixed{};
  std::string bounds{};
  study::ReadingSettings reading{};
  InferenceOptions inference{};
  ResamplingArguments resampling{};
};

/// Options of the model: formula, sub-models, random effects and variance function.
void add_model_options(CLI::App& command, FitArguments& arguments);

/// Options of the fit: method, bounds and start values of the coefficients.
void add_method_options(CLI::App& command, FitArguments& arguments);

}  // namespace silvafit::cli
