// SPDX-License-Identifier: MIT
// A study of the small stand with its record, as the program would make it.
#pragma once

#include <sstream>
#include <string>

#include "scratch_file.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/study_files.hpp"
#include "study/study_test_support.hpp"

namespace silvafit::test {

inline std::string csv_text(const data::Table& table) {
  std::ostringstream text;
  data::write_csv_table(table, text);
  return text.str();
}

/// Writes the stand to a file without indices, reads it, and runs a study.
struct RecordedStudy {
  explicit RecordedStudy(const StandDesign& design)
      : file(csv_text(stand({.plots = design.plots,
                             .trees = design.trees,
                             .has_indices = false,
                             .species = design.species}))) {
    record.version = "0";
    record.command = "silvafit study stand.csv --out out";
    record.decisions = {{"Window", "none"}};
    record.inventory = stand::read_inventory(file.path());
    record.table = study::inventory_table(record.inventory.inventory, record.units);
    record.study = study::run_study(record.table, catalogue(), {.responses = {"h"}});
  }

  ScratchFile file;
  study::StudyRecord record{};
};

}  // namespace silvafit::test
