// SPDX-License-Identifier: MIT
// Imputation of a table of trees, from a file or data frame to its columns.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/impute.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

struct TableImputation {
  ImputeOptions options{};
  data::Table table{};                    ///< as it was read
  std::vector<std::string> recognized{};  ///< how it was read
  Imputation imputation{};                ///< with the notes
};

/// Reads a table and fills in a response where it was not measured.
/// \throws InputError also if the table has columns of the names that imputed_columns() adds; else
///   as read_model_table and impute
TableImputation impute_table(const data::TableSource& trees,
                             const Catalogue& catalogue,
                             const ImputeOptions& options = {},
                             const ReadingSettings& reading = {},
                             const Callbacks& callbacks = {});

/// Names of the columns that come to a response: h_source, h_level, h_flag.
std::vector<std::string> imputation_columns(const std::string& response);

/// The response, measured or imputed, and the columns of imputation_columns().
data::Table imputed_columns(const TableImputation& imputed);

/// The models, and how many trees were imputed with which, as sentences.
std::vector<std::string> summary_of(const TableImputation& imputed);

/// In short as JSON, schema silvafit-impute/1 (docs/impute.md).
/// \param out  file that the table was written to; may be empty
nlohmann::ordered_json json_of(const TableImputation& imputed, const std::string& out = {});

}  // namespace silvafit::study
