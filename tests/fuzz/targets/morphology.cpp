// SPDX-License-Identifier: MIT
#include "fuzz_target.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/tree/morphology_table.hpp"

void silvafit::fuzz::read(std::string_view bytes) {
  const FileOfBytes file(bytes);
  const data::Table table =
      data::read_csv_table(file.path(), {.text_columns = {"plot", "tree", "species"}});
  tree::read_morphologies(table, {});
}
