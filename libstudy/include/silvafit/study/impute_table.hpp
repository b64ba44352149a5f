// SPDX-License-Identifier: MIT
// Imputation of a table of trees, from a file or data frame to its columns.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/impute.hpp"
#include "silvafit/study/rows_with_columns.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

struct TableImputation {
  ImputeOptions options{};
  std::string column{};                   ///< name of the response in the file
  data::Table table{};                    ///< as it was read
  std::vector<std::string> recognized{};  ///< how it was read
  Imputation imputation{};                ///< with the notes
  bool is_in_file_order = true;           ///< else a part of a file that was sorted by plot
};

/// Reads a table and fills in a response where it was not measured.
/// \throws InputError also if the table has columns of the names that imputed_columns() adds; else
///   as read_model_table and impute
TableImputation impute_table(const data::TableSource& trees,
                             const Catalogue& catalogue,
                             const ImputeOptions& options = {},
                             const ReadingSettings& reading = {},
                             const Callbacks& callbacks = {});

/// Results and notes on all trees together.
struct ImputationSummary {
  ImputeOptions options{};
  std::vector<ImputeModel> models{};
  std::size_t trees = 0;
  std::map<ImputeSource, std::size_t> sources{};
  std::map<ImputeLevel, std::size_t> levels{};
  std::map<std::string, std::size_t> flags{};
  std::vector<std::string> recognized{};
  std::vector<std::string> notes{};
};

/// Receives the rows of the table, or of a part of it, with the imputed values.
using ImputationSink = std::function<void(const data::TableSource& rows, TableImputation& part)>;

/// The same for a table of any size.
/// \param is_in_parts  for a CSV file that does not fit in memory: the models are fitted to the
///   measured trees, which are all in memory, and the file is filled in parts of whole plots. If
///   their rows are not contiguous, they are sorted on disk, with a note.
/// \throws as impute_table; in parts UsageError if the source is no CSV file, or with add_residual,
///   whose random numbers are drawn for all plots together
ImputationSummary impute_trees(const data::TableSource& trees,
                               const Catalogue& catalogue,
                               const ImputeOptions& options,
                               const ReadingSettings& reading,
                               bool is_in_parts,
                               const ImputationSink& sink,
                               const Callbacks& callbacks = {});

/// Names of the columns that are added for a column: h_source, h_level, h_flag, and with intervals
/// h_lower and h_upper.
std::vector<std::string> imputation_columns(const std::string& column, bool has_intervals);

/// The response, measured or imputed, and the columns of imputation_columns().
data::Table imputed_columns(const TableImputation& imputed);

/// The columns that the file of the table gets. The response is filled in under its name in the
/// file; it is a new column if the file has another unit or a formula makes it.
/// \param imputed  has to live as long as the result
AddedColumns added_columns(const TableImputation& imputed, int digits);

/// Sentences on the models and on the number of trees imputed with each.
std::vector<std::string> summary_of(const ImputationSummary& summary);
std::vector<std::string> summary_of(const TableImputation& imputed);

/// As JSON, schema silvafit-impute/1 (docs/impute.md).
/// \param out  file that the table was written to; may be empty
nlohmann::ordered_json json_of(const ImputationSummary& summary, const std::string& out = {});

}  // namespace silvafit::study
