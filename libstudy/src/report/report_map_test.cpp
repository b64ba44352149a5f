// SPDX-License-Identifier: MIT
// The map of the report page against its stand.
#include <catch2/catch.hpp>

#include "report/report_json.hpp"
#include "scratch_file.hpp"
#include "silvafit/stand/structural_units.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

constexpr char kTrees[] =
    "plot,tree,species,x,y,dbh,h,cw\n"
    "07,1,SM,1,2,20,9,2\n"
    "07,2,MH,9.12345,8,30,10,4\n"
    "8,1,SM,101,2,25,25,\n"
    "8,2,,109,8,25,,3\n";

StudyRecord record_of(const stand::StructuralUnitOptions& options) {
  const test::ScratchFile file(kTrees, ".csv");
  StudyRecord record;
  record.inventory = stand::read_inventory(file.path(), {.trust_units = true});
  record.units = stand::structural_units(record.inventory.inventory, options);
  return record;
}

}  // namespace

TEST_CASE("the map has every window and tree, and each tree's neighbors by row") {
  const auto map = report_map(
      record_of({.neighbors = 1,
                 .buffer_m = 1.5,
                 .windows = {{"07", stand::Window::rectangle({0, 0}, {10, 10})},
                             {"8",
                              stand::Window({{.outer = {{100, 0}, {110, 0}, {110, 10}, {100, 10}},
                                              .holes = {{{104, 4}, {105, 4}, {105, 5}}}}})}}}));
  REQUIRE(map);
  const auto& found = *map;
  CHECK(found["areas"][0]["name"] == "07");
  CHECK(found["areas"][0]["rings"][0].size() == 4);
  CHECK(found["areas"][1]["rings"].size() == 2);
  CHECK(found["buffer"] == 1.5);
  CHECK(found["area"] == nlohmann::ordered_json({0, 0, 1, 1}));
  CHECK(found["species_names"] == nlohmann::ordered_json({"SM", "MH"}));
  CHECK(found["species"] == nlohmann::ordered_json({0, 1, 0, nullptr}));
  CHECK(found["x"][1] == 9.123);
  CHECK(found["layer"] == nlohmann::ordered_json({0, 1, 2, nullptr}));
  CHECK(found["cw"] == nlohmann::ordered_json({2.0, 4.0, nullptr, 3.0}));
  CHECK(found["core"] == nlohmann::ordered_json({0, 0, 0, 0}));
  CHECK(found["U"] == nlohmann::ordered_json({1.0, 0.0, 1.0, 1.0}));
  CHECK(found["W"][0].is_null());
  CHECK(found["nearest"] == nlohmann::ordered_json({{1}, {0}, {3}, {2}}));
}

TEST_CASE("without windows each plot is an area without rings, without units there is no map") {
  StudyRecord record = record_of({.neighbors = 1, .edge = stand::EdgeCorrection::kNone});
  const auto map = report_map(record);
  REQUIRE(map);
  CHECK((*map)["areas"].size() == 2);
  CHECK((*map)["areas"][1]["rings"].empty());
  CHECK((*map)["buffer"] == 0.0);
  CHECK((*map)["area"] == nlohmann::ordered_json({0, 0, 1, 1}));
  record.units.reset();
  CHECK_FALSE(report_map(record));
}
