// SPDX-License-Identifier: MIT
// A table of which each rank of a job reads its part.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/fit/shared_fit.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/tree_table.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// The rows of a rank, and the sample.
struct SharedTable {
  fit::SharedData data{};
  std::vector<std::string> recognized{};  ///< of the sample
};

/// Reads the rows of this rank from a CSV file, and the sample of all ranks.
///
/// The file is cut into parts of whole groups with at least 4096 rows; each rank has a contiguous
/// share of them. The sample has every n-th group, about 40,000 rows, and the first group with each
/// label of a column of texts that has at most 200 different ones. Units and spellings are those
/// of the sample. Each rank reads the whole file, but keeps its rows only.
/// \param group  the column of the groups
/// \param where  condition for rows; empty: all
/// \throws as data::TableParts and read_model_table
SharedTable read_shared_table(const data::TableSource& source,
                              const ReadingSettings& settings,
                              const ModelColumns& columns,
                              const std::string& group,
                              const std::string& where,
                              const NoteCallback& note = {});

}  // namespace silvafit::study
