// SPDX-License-Identifier: MIT
// What tests/reference ships: figures of other programs, and the stands that most of them are of.
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::test {

/// A file of tests/reference/expected.
inline nlohmann::json read_expected(const std::string& name) {
  std::ifstream stream(source_file("tests/reference/expected/" + name));
  return nlohmann::json::parse(stream);
}

/// The simulated trees of tests/reference/data/stands.csv.
inline data::Table stands() { return data::read_csv_table(reference_data("stands.csv")); }

}  // namespace silvafit::test
