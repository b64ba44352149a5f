// SPDX-License-Identifier: MIT
#include "silvafit/tree/morphology_table.hpp"

#include <catch2/catch.hpp>

#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "test_support/tree_test_support.hpp"

using Catch::Matchers::Contains;
using namespace silvafit;
using namespace silvafit::tree;

namespace {

data::Table table_of(const std::string& csv) {
  const test::ScratchFile file(csv);
  const data::CsvTableOptions options{.text_columns = {"plot", "tree", "species"}};
  return data::read_csv_table(file.path(), options);
}

const char* const kInventory =
    "plot,tree,species,x,y,z,dbh,h,hcb,cw,cr_e,cr_w,cr_s,cr_n\n"
    "01,7,SM,1.5,2.5,100,20.5,15.5,5.5,4,1,2,2,3\n"
    "01,8,SM,1,1,100,20,15,5,4,,2,2,3\n"
    "01,9,SM,1,1,100,,15,5,4,1,2,2,3\n"
    "01,10,SM,1,1,100,20,15,16,4,1,2,2,3\n"
    "01,7,SM,1,1,100,20,15,5,4,1,2,2,3\n"
    "02,7,SM,,1,100,20,15,5,4,1,2,2,3\n";

}  // namespace

TEST_CASE("an inventory is read row by row, and rows that cannot be used are reported") {
  const MorphologyTable read = read_morphologies(table_of(kInventory), {.needs_position = true});
  REQUIRE(read.morphologies.size() == 2);
  const Morphology& first = read.morphologies[0];
  CHECK(first.plot == "01");
  CHECK(first.tree == "7");
  CHECK(first.position.y_m == 2.5);
  CHECK(first.h_m == 15.5);
  REQUIRE(first.radii);
  CHECK(first.radii->north_m == 3.0);
  // One radius is missing: the crown width is used.
  CHECK_FALSE(read.morphologies[1].radii);
  CHECK(read.morphologies[1].cw_m == 4.0);

  REQUIRE(read.left_out.size() == 4);
  CHECK(read.left_out[0].place.tree == "9");
  CHECK(read.left_out[0].place.column == "dbh");
  CHECK(read.left_out[0].place.line == 4);
  CHECK(read.left_out[1].place.column == "hcb");
  CHECK(read.left_out[2].place.line == 6);
  CHECK(read.left_out[3].place.plot == "02");
  CHECK(read.left_out[3].place.column == "x");
}

TEST_CASE("a tree without a label of its own or of its plot is skipped") {
  const MorphologyTable read =
      read_morphologies(table_of("Place,tree,dbh,h,hcb,cw\n1,1,20,15,5,4\n,2,20,15,5,4\n"
                                 "1,NA,20,15,5,4\n"),
                        {.columns = {{"plot", "Place"}}});
  CHECK(read.morphologies.size() == 1);
  REQUIRE(read.left_out.size() == 2);
  CHECK(read.left_out[0].place.line == 3);
  CHECK(read.left_out[0].place.column == "Place");
  CHECK(read.left_out[1].place.column == "tree");
  CHECK(read.left_out[1].reason == "is missing");
}

TEST_CASE("positions are not needed for single trees") {
  const MorphologyTable read = read_morphologies(table_of(kInventory), {.plots = {"02"}});
  REQUIRE(read.morphologies.size() == 1);
  CHECK(read.morphologies[0].position.z_m == 0.0);
  CHECK_THROWS_AS(read_morphologies(table_of(kInventory), {.plots = {"3"}}), InputError);
}

TEST_CASE("a crown may end at the stem on one side, and four radii of 0 are missing") {
  const MorphologyTable read =
      read_morphologies(table_of("plot,tree,species,x,y,dbh,h,hcb,cw,cr_e,cr_w,cr_s,cr_n\n"
                                 "1,1,A,0,0,20,15,5,4,3,0,2,2\n1,2,A,0,5,20,15,5,4,0,0,0,0\n"),
                        {});
  REQUIRE(read.morphologies.size() == 2);
  REQUIRE(read.morphologies[0].radii);
  CHECK(read.morphologies[0].radii->east_m == 3.0);
  CHECK(read.morphologies[0].radii->west_m == 0.01);
  CHECK_FALSE(read.morphologies[1].radii);
  CHECK(read.morphologies[1].cw_m == 4.0);
}

TEST_CASE("unfitted trees need no column but plot, tree and h") {
  const MorphologyTable read = read_morphologies(
      table_of("plot,tree,h,dbh\n1,1,12.5,unknown\n1,2,1.2,3\n1,3,,4\n"), {.only_height = true});
  REQUIRE(read.morphologies.size() == 1);
  CHECK(read.morphologies[0].h_m == 12.5);
  CHECK_FALSE(read.morphologies[0].cw_m);
  REQUIRE(read.left_out.size() == 2);
  CHECK(read.left_out[0].place.column == "h");
  CHECK_THAT(read.left_out[1].reason, Contains("missing"));
}

TEST_CASE("predictions are chosen by level, without measured radii") {
  const data::Table table = table_of(
      "plot,tree,species,dbh,h,hcb,cw,cr_e,cr_w,cr_s,cr_n,h_population,hcb_population,"
      "cw_population\n"
      "1,1,SM,20,,,,1,1,1,1,14,6,3.5\n");
  const MorphologyTable read = read_morphologies(table, {.use = Use::kPopulation});
  REQUIRE(read.morphologies.size() == 1);
  CHECK(read.morphologies[0].h_m == 14.0);
  CHECK(read.morphologies[0].cw_m == 3.5);
  CHECK_FALSE(read.morphologies[0].radii);
  CHECK(read_morphologies(table, {}).left_out.size() == 1);
  CHECK_THROWS_AS(read_morphologies(table, {.use = Use::kConditional}), InputError);
}

TEST_CASE("a cell with text excludes only its row") {
  const MorphologyTable read = read_morphologies(
      table_of("plot,tree,species,dbh,h,hcb,cw\n1,1,SM,20,15,6,3\n1,2,SM,thick,15,6,3\n"), {});
  CHECK(read.morphologies.size() == 1);
  REQUIRE(read.left_out.size() == 1);
  CHECK(read.left_out[0].reason == "'thick' is not a number");
  CHECK(read.left_out[0].place.column == "dbh");
  CHECK(read.left_out[0].place.tree == "2");
  CHECK_THROWS_AS(read_morphologies(table_of("plot,tree,dbh,h,hcb,cw\n1,1,thick,15,6,3\n"), {}),
                  InputError);
}

TEST_CASE("columns of other names and units are mapped") {
  const data::Table table = table_of("Plot,No,BHD,Hoehe,KA,KB\nA,1,205,15.5,5,4\n");
  const MorphologyTableOptions options{.columns = {{"plot", "Plot"},
                                                   {"tree", "No"},
                                                   {"dbh", "BHD/10"},
                                                   {"h", "Hoehe"},
                                                   {"hcb", "KA"},
                                                   {"cw", "KB"}}};
  const MorphologyTable read = read_morphologies(table, options);
  REQUIRE(read.morphologies.size() == 1);
  CHECK(read.morphologies[0].dbh_cm == 20.5);
  CHECK(read.morphologies[0].plot == "A");
  CHECK_THROWS_AS(read_morphologies(table, {}), InputError);
  CHECK_THROWS_AS(read_morphologies(table, {.columns = {{"bhd", "BHD"}}}), UsageError);
}

TEST_CASE("columns are named as in the header, in expressions in backquotes") {
  const data::Table table =
      table_of("plot,tree,BHD [cm],H.m,crown base,cw\nA,1,20.5,15.5,n.v.,4\nA,2,20.5,15.5,5,4\n");
  MorphologyTableOptions options{
      .columns = {{"dbh", "BHD [cm]"}, {"h", "H.m"}, {"hcb", "crown base"}}};
  MorphologyTable read = read_morphologies(table, options);
  REQUIRE(read.morphologies.size() == 1);
  CHECK(read.morphologies[0].dbh_cm == 20.5);
  CHECK(read.morphologies[0].hcb_m == 5.0);
  REQUIRE(read.left_out.size() == 1);
  CHECK(read.left_out[0].place.column == "crown base");
  CHECK(read.left_out[0].reason == "'n.v.' is not a number");
  options.columns["dbh"] = "`BHD [cm]`*2";
  options.columns["hcb"] = "`crown base`/2";
  read = read_morphologies(table, options);
  REQUIRE(read.morphologies.size() == 1);
  CHECK(read.morphologies[0].dbh_cm == 41.0);
  CHECK(read.morphologies[0].hcb_m == 2.5);
  CHECK(read.left_out.size() == 1);
  options.columns["dbh"] = "BHD [cm]*2";
  CHECK_THROWS_WITH(read_morphologies(table, options), Contains("`BHD [cm]`, in backquotes"));
}

TEST_CASE("the reason for a skipped row names the missing column") {
  const data::Table table = table_of(
      "plot,tree,D,h,hcb,cw,h_ols,hcb_ols,cw_ols\n1,1,200,15,6,3,,6,3\n1,2,,15,6,3,14,6,3\n");
  const MorphologyTable read =
      read_morphologies(table, {.use = Use::kOls, .columns = {{"dbh", "D/10"}}});
  REQUIRE(read.left_out.size() == 2);
  CHECK(read.left_out[0].place.column == "h_ols");
  CHECK(read.left_out[1].place.column == "D/10");
}

TEST_CASE("an unknown plot is refused with the existing ones") {
  std::string csv = "plot,tree,dbh,h,hcb,cw\n01,1,20,15,5,3\n";
  CHECK_THROWS_WITH(read_morphologies(table_of(csv), {.plots = {"01", "1"}}),
                    Contains("no trees in plot 1; the only plot is 01"));
  for (int plot = 2; plot <= 12; ++plot) {
    csv += std::to_string(plot) + ",1,20,15,5,3\n";
  }
  CHECK_THROWS_WITH(read_morphologies(table_of(csv), {.plots = {"Z"}}),
                    Contains("available: 01, 2, 3, 4, 5, 6, 7, 8, 9, 10 and 2 more"));
}
