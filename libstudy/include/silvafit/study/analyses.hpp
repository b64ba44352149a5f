// SPDX-License-Identifier: MIT
// All analyses by their names, for R and Python: arguments as JSON, results as tables and JSON.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/setting_names.hpp"

namespace silvafit::study {

/// What an analysis works on. Those of fits need `fits`, and most also the rows of the fit.
struct AnalysisInput {
  /// An object with the settings of the analysis by their keys (docs/settings.md), `threads`,
  /// `seed` and what the analysis itself has; unknown keys are errors.
  std::string arguments = "{}";
  std::optional<data::TableSource> table{};  ///< trees, or rows of a fit
  std::optional<data::TableSource> plots{};  ///< the table of plots in memory
  std::vector<const fit::FittedModel*> fits{};
  const ModelLibrary* library = nullptr;  ///< of predictions; must outlive the work
  std::filesystem::path data_folder{};    ///< with models/ and viewer/
  const Catalogue* catalogue = nullptr;   ///< that of the folder, if it has been read already
  Front front = Front::kR;                ///< in whose words messages of results are
};

struct AnalysisResult {
  std::vector<std::pair<std::string, data::Table>> tables{};
  std::vector<std::size_t> rows{};  ///< of the input, from 0, that the first table has
  /// Columns of the input that the labels of tables are from, by the names of these.
  std::map<std::string, std::string> label_columns{};
  std::string json{};  ///< what is no table; an object, or empty
  std::vector<std::pair<std::string, fit::FittedModel>> fits{};  ///< by label
  std::optional<ModelLibrary> library{};
  /// What was left out: rows, models, predictions; notes of rows say so, too.
  std::vector<std::string> warnings{};
};

/// What an analysis reports while it runs.
struct AnalysisCallbacks : Callbacks {
  std::stop_token stop{};
  std::function<void(const std::string&)> line{};  ///< of a trace; from any thread
};

/// The work of an analysis, which may run on another thread than prepare().
using AnalysisWork = std::function<AnalysisResult(const AnalysisCallbacks&)>;

/// Reads the arguments of an analysis: structural_units, stand_summary, stand_growth, impute,
/// predict_library, study, grow, view, fit, predict, intervals, bootstrap, cross_validate, compare,
/// simulate, residuals, covariance, term_tests, calibrate.
/// \throws UsageError that names an argument that is unknown or whose value cannot be used
AnalysisWork prepare_analysis(std::string_view name, AnalysisInput input);

}  // namespace silvafit::study
