// SPDX-License-Identifier: MIT
// Predictions of a model library for a table of trees, from a file or data frame to new columns.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/predict_responses.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// PredictResponsesOptions in words, and how the table is read.
struct PredictionSettings {
  ReadingSettings reading{};
  /// Volume, biomass and carbon of the trees, with predicted heights where none is measured.
  EquationSettings equations{};
  std::string level = "population";          ///< population, conditional, calibrated or marginal
  std::string new_groups = "population";     ///< population, marginal, missing or error
  std::string seen_groups = "fitted";        ///< of calibrated predictions: fitted, new or combined
  double interval = 0.0;                     ///< coverage; 0: no intervals
  std::string interval_kind = "prediction";  ///< prediction or confidence
  bool standard_errors = false;
  /// ols, covariates or nlme; empty: nlme, or the next simpler model where a column is not there.
  std::string role{};
  unsigned threads = 0;  ///< 0: as many as there are cores
};

struct TablePrediction {
  PredictionSettings settings{};
  data::Table table{};                            ///< as it was read, with computed indices
  std::vector<std::string> recognized{};          ///< how it was read
  PredictedResponses predictions{};               ///< with the notes
  std::vector<stand::TreeQuantity> quantities{};  ///< of the equations
};

/// Reads a table and predicts each response of the library. Structural indices that models need and
/// `reading.columns` asks for (`C=C`) are computed as in the study that the library is from.
/// \param catalogue  has the domains of models
/// \throws UsageError if settings cannot be used; else as read_model_table and predict_responses
TablePrediction predict_table(const data::TableSource& trees,
                              const ModelLibrary& library,
                              const Catalogue& catalogue,
                              const PredictionSettings& settings = {},
                              const Callbacks& callbacks = {});

/// The new columns of N rows: for each response h_pred and, where asked for, h_lower, h_upper, h_se
/// and h_trees (measured trees that calibrated, or "fitted"), then quantities such as volume_m3,
/// then flag.
data::Table new_columns(const TablePrediction& prediction);

/// In short as JSON, schema silvafit-predict/1 (docs/predict.md).
/// \param out  file that the predictions were written to; may be empty
nlohmann::ordered_json json_of(const TablePrediction& prediction, const std::string& out = {});

}  // namespace silvafit::study
