// SPDX-License-Identifier: MIT
#include "silvafit/stand/similar_plots.hpp"

#include <catch2/catch.hpp>
#include <initializer_list>

using Catch::Matchers::Contains;
using silvafit::stand::describe_similar_labels;

namespace {

std::string note_on(std::initializer_list<const char*> labels) {
  silvafit::data::TextColumn column;
  for (const char* const label : labels) column.append(label);
  return describe_similar_labels(column);
}

}  // namespace

TEST_CASE("plots whose labels differ in capitals or zeros are named") {
  CHECK_THAT(note_on({"1", "2", "001"}), Contains("'1' and '001';"));
  CHECK_THAT(note_on({"a-07", "b", "A-7"}), Contains("'a-07' and 'A-7';"));
  CHECK_THAT(note_on({"0", "000"}), Contains("'0' and '000';"));
  CHECK_THAT(note_on({"P0x", "p00X"}), Contains("'P0x' and 'p00X';"));
  CHECK_THAT(note_on({"1", "2", "1.0", "2.5"}), Contains("'1' and '1.0';"));
  CHECK_THAT(note_on({"1", "01", "001", "0001", "00001"}), Contains("' and 1 more;"));
  CHECK_THAT(note_on({"A 1", "A1"}), Contains("'A 1' and 'A1';"));
  CHECK_THAT(note_on({"A-1", "A\u20131"}), Contains("'A-1' and"));
}

TEST_CASE("a label that is a code of missing values is named") {
  CHECK_THAT(note_on({"1", "-9999"}), Contains("-9999 is a label of plot;"));
  CHECK_THAT(note_on({"1", "n/a"}), Contains("n/a is a label of plot;"));
  CHECK_THAT(note_on({"-", "A"}), Contains("- is a label of plot;"));
  CHECK(note_on({"9999", "-1", "none", "NB"}).empty());
}

TEST_CASE("plots with other labels are not") {
  CHECK(note_on({}).empty());
  CHECK(note_on({"1", "10", "100", "2"}).empty());
  CHECK(note_on({"1 1", "11", "1-1", "A-1", "A1"}).empty());
  CHECK(note_on({"x1.5", "x1.05", "x1.0", "x1.00"}).empty());
  CHECK(note_on({"A1", "B1", "A10", "A", ""}).empty());
}
