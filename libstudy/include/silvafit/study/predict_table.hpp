// SPDX-License-Identifier: MIT
// Predictions of a model library for a table of trees, from a file or data frame to new columns.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/predict_responses.hpp"

namespace silvafit::study {

struct TablePrediction {
  PredictionSettings settings{};
  data::Table table{};                            ///< as it was read, with computed indices
  std::vector<std::string> recognized{};          ///< how it was read
  PredictedResponses predictions{};               ///< with the notes
  std::vector<stand::TreeQuantity> quantities{};  ///< of the equations
  bool is_in_file_order = true;                   ///< else a part of a file that was sorted by plot
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

/// Results and notes on all trees together.
struct PredictionSummary {
  PredictionSettings settings{};
  std::size_t trees = 0;
  std::vector<std::pair<std::string, std::size_t>> predicted{};  ///< trees, by response
  std::map<std::string, std::size_t> flags{};
  std::vector<UnusedModel> unused{};
  std::vector<std::string> recognized{};
  std::vector<std::string> notes{};
};

/// Receives the rows of the table, or of a part of it, with their predictions.
using PredictionSink = std::function<void(const data::TableSource& rows, TablePrediction& part)>;

/// The same for a table of any size.
/// \param is_in_parts  reads a CSV file that does not fit in memory in parts, each with whole plots
///   (or coarser groups) where predictions of a tree depend on others, by calibration or by
///   computed indices. If their rows are not contiguous, they are sorted on disk, with a note.
/// \throws as predict_table; in parts UsageError if the source is no CSV file, or trees of all
/// plots
///   depend on each other
PredictionSummary predict_trees(const data::TableSource& trees,
                                const ModelLibrary& library,
                                const Catalogue& catalogue,
                                const PredictionSettings& settings,
                                bool is_in_parts,
                                const PredictionSink& sink,
                                const Callbacks& callbacks = {});

/// As JSON, schema silvafit-predict/1 (docs/json.md).
/// \param out  file that the predictions were written to; may be empty
nlohmann::ordered_json json_of(const PredictionSummary& summary, const std::string& out = {});

}  // namespace silvafit::study
