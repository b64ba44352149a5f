// SPDX-License-Identifier: MIT
// A model library, and predictions by it for a small table.
#include <vector>

#include "fuzz_target.hpp"
#include "silvafit/study/predict_responses.hpp"

namespace {

silvafit::data::Table small_table() {
  silvafit::data::Table table(4);
  table.set("dbh", {10.0, 20.0, 30.0, -1.0});
  table.set("h", {8.0, 15.0, 19.0, 1e308});
  for (const char* name : {"W", "M", "U", "C"}) table.set(name, {0.0, 0.25, 0.5, 1.0});
  for (const char* name : {"plot", "species"}) {
    silvafit::data::TextColumn text;
    for (const char* value : {"1", "1", "SM", "9"}) text.append(value);
    table.set(name, std::move(text));
  }
  return table;
}

}  // namespace

void silvafit::fuzz::read(std::string_view bytes) {
  const FileOfBytes file(bytes);
  const study::ModelLibrary library = study::read_library(file.path());
  static const data::Table table = small_table();
  for (const fit::Level level : {fit::Level::kPopulation, fit::Level::kCalibrated}) {
    study::predict_responses(library, table, {.level = level, .interval = 0.95});
  }
}
