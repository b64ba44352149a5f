// SPDX-License-Identifier: MIT
#include "silvafit/stand/inventory.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "reference.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/inventory_test_support.hpp"

using namespace silvafit::stand;
using Catch::Matchers::Contains;
using silvafit::InputError;

namespace {

/// Twelve trees whose values of one column are multiplied by a factor.
std::string stand_with(const std::string& column, double factor) {
  std::string text = "tree,species,x,y,dbh,h,hcb,cw\n";
  const std::vector<std::string> names{"x", "y", "dbh", "h", "hcb", "cw"};
  for (int i = 0; i < 12; ++i) {
    const int row = i / 4;
    const std::vector<double> values{5.0 * (i % 4), 5.0 * row, 22.0 + i, 18.0, 7.5, 4.0};
    text += std::to_string(i) + ",SM";
    for (std::size_t k = 0; k < names.size(); ++k) {
      text += "," + std::to_string(values[k] * (names[k] == column ? factor : 1.0));
    }
    text += "\n";
  }
  return text;
}

}  // namespace

TEST_CASE("an inventory is read with the lines of its trees in the file") {
  const CheckedInventory checked = read_inventory_text(
      "plot,tree,species,x,y,dbh,h,hcb,cw,note\n"
      "07,31,SM,1.5,2,20.4,18.5,9,4.2,leaning\n"
      "\n"
      "07,32, 杉木 ,3,4,11,NA,,,\n");
  const Inventory& inventory = checked.inventory;
  REQUIRE(inventory.size() == 2);
  CHECK(inventory.plot[0] == "07");
  CHECK(inventory.species[1] == "杉木");
  CHECK(inventory.dbh_cm == std::vector<double>{20.4, 11.0});
  CHECK(inventory.hcb_m[0] == 9.0);
  CHECK(std::isnan(inventory.h_m[1]));
  CHECK(inventory.z.empty());
  CHECK(inventory.cr_e_m.empty());
  CHECK(inventory.place(1).line == 4);
  CHECK(inventory.place(1).tree == "32");
  CHECK(inventory.other.names().empty());
  CHECK(checked.excluded.empty());
  CHECK(checked.notes.empty());
}

TEST_CASE("all problems of all rows are reported, and these rows are skipped") {
  const CheckedInventory checked = read_inventory_text(
      "plot,tree,species,x,y,dbh,h,hcb,cw\n"
      "1,1,SM,0,0,20,15,7,4\n"
      "1,2,SM,0,1,twenty,15,7,4\n"
      "1,3,SM,0,2,-3,1.3,-1,0\n"
      "1,4,SM,0,3,20,15,15,4\n"
      "1,5,SM,0,4,NA,15,7,4\n"
      "1,6,SM,inf,5,20,15,7,4\n"
      "1,7,SM,,6,20,15,7,4\n"
      "1,,SM,0,7,20,15,7,4\n"
      "NA,9,SM,0,8,x,15,7,4\n"
      "1,10,,0,9,20,15,7,4\n"
      "1,11,SM,0,9,\"c. 20\",15,7,4\n",
      {.needs_coordinates = true});
  CHECK(problems(checked) ==
        std::vector<std::string>{
            "3 dbh: 'twenty' is not a number; leave missing values empty or write NA, or name "
            "other codes with `missing`",
            "4 dbh: -3 cm is not above 0 cm",
            "4 h: 1.3 m is not above breast height, 1.3 m",
            "4 hcb: -1 m is not 0 m or more",
            "5 hcb: 15 m is not below h 15 m",
            "7 x: the value is not finite",
            "8 x: is missing, so the tree has no position",
            "9 tree: the tree number is missing",
            "10 plot: the plot is missing",
            "10 dbh: 'x' is not a number; leave missing values empty or write NA, or name other "
            "codes with `missing`",
            "12 dbh: 'c. 20' is not a number; leave missing values empty or write NA, or name "
            "other codes with `missing`"});
  CHECK(checked.excluded_tree_count == 8);
  REQUIRE(checked.inventory.size() == 3);
  CHECK(checked.inventory.tree[2] == "10");
  CHECK(checked.inventory.species.is_missing(2));
  // Tree 5 has no dbh.
  CHECK(checked.inventory.neighbor_only == std::vector<char>{0, 1, 0});
  CHECK(has_note(checked, "1 tree has no species"));

  const std::string text = describe_excluded(checked, 2);
  CHECK_THAT(text, Contains("8 of 11 rows skipped, 11 problems"));
  CHECK_THAT(text,
             Contains(".csv:3: dbh: 'twenty' is not a number; leave missing values empty or write "
                      "NA, or name other codes with `missing` (plot 1, tree 2)"));
  CHECK_THAT(text, Contains("and 9 more"));
  CHECK(has_note(checked, "codes read as missing values: cw 1 (0)"));

  std::ostringstream csv;
  write_excluded(checked.excluded, csv);
  CHECK_THAT(csv.str(), Contains("line,plot,tree,column,value,reason\n"));
  CHECK_THAT(csv.str(),
             Contains("3,1,2,dbh,twenty,\"'twenty' is not a number; leave missing values empty"));
  CHECK_THAT(csv.str(), Contains("12,1,11,dbh,c. 20,\"'c. 20' is not a number;"));
}

TEST_CASE("a tree without dbh is a neighbor if its position is known") {
  const std::string rows = "1,1,SM,0,0,20\n1,2,SM,1,0,\n1,3,SM,0,1,0\n1,4,SM,,,-\n1,5,SM,2,2,21\n";
  const CheckedInventory checked = read_inventory_text("plot,tree,species,x,y,dbh\n" + rows);
  REQUIRE(checked.inventory.size() == 4);
  CHECK(checked.inventory.neighbor_only == std::vector<char>{0, 1, 1, 0});
  CHECK(std::isnan(checked.inventory.dbh_cm[1]));
  CHECK(problems(checked) ==
        std::vector<std::string>{"5 dbh: is missing, and a tree without dbh and position cannot be "
                                 "used"});
  CHECK(has_note(checked, "2 trees are without dbh: neighbors of others, but not core trees"));
  CHECK_THROWS_WITH(read_inventory_text("plot,tree,x,y,dbh\n1,1,0,0,\n1,2,1,0,NA\n"),
                    Contains("dbh is missing in all rows"));
}

TEST_CASE("without a need for coordinates trees without them are used") {
  const CheckedInventory checked = read_inventory_text("plot,tree,species,x,y,dbh\n1,1,SM,,,20\n");
  CHECK(checked.inventory.size() == 1);
  CHECK(checked.excluded.empty());
}

TEST_CASE("a repeated row of a tree is skipped, another tree with the same number is kept") {
  const CheckedInventory checked = read_inventory_text(
      "plot,tree,species,x,y,dbh\n"
      "1,5,SM,0,0,20\n"
      "2,5,SM,0,0,20\n"
      "1,5,SM,0,0,20\n"
      "1,5#2,SM,1,0,22\n"
      "1,5,SM,2,0,20\n"
      "1,5,SM,3,0,20\n");
  CHECK(problems(checked) == std::vector<std::string>{"4 tree: the same tree is on line 2"});
  REQUIRE(checked.inventory.size() == 5);
  CHECK(checked.inventory.tree[1] == "5");
  CHECK(checked.inventory.tree[3] == "5#3");
  CHECK(checked.inventory.tree[4] == "5#4");
  CHECK(checked.inventory.x == std::vector<double>{0, 0, 1, 2, 3});
  CHECK(has_note(checked, "2 trees have the number of another tree of the same plot"));

  // Missing diameters at one position are equal, and differ from known ones.
  const CheckedInventory without_dbh = read_inventory_text(
      "plot,tree,species,x,y,dbh\n1,5,SM,0,0,20\n1,5,SM,0,0,\n1,5,SM,0,0,30\n1,5,SM,0,0,\n"
      "1,5,SM,0,0,20\n");
  CHECK(problems(without_dbh) == std::vector<std::string>{"5 tree: the same tree is on line 3",
                                                          "6 tree: the same tree is on line 2"});

  const CheckedInventory unplaced =
      read_inventory_text("plot,tree,species,dbh,h\n1,5,SM,20,15\n1,5,SM,20,15\n1,5,SM,20,16\n");
  CHECK(unplaced.excluded_tree_count == 1);
  CHECK(unplaced.inventory.size() == 2);
}

TEST_CASE("stems of one stool with one number and position are separate trees") {
  const CheckedInventory checked = read_inventory_text(
      "plot,tree,species,x,y,dbh,h\n"
      "1,1,A,1,1,20,10\n"
      "1,1,A,1,1,12,9\n"
      "1,1,A,1,1,8,8\n"
      "1,2,A,5,5,20,10\n"
      "1,1,A,1,1,12,9\n"
      "1,2,A,5,5,20,NA\n");
  CHECK(problems(checked) == std::vector<std::string>{"6 tree: the same tree is on line 3",
                                                      "7 tree: the same tree is on line 5"});
  const Inventory& inventory = checked.inventory;
  REQUIRE(inventory.size() == 4);
  CHECK(inventory.tree[0] == "1");
  CHECK(inventory.tree[1] == "1#2");
  CHECK(inventory.tree[2] == "1#3");
  CHECK(inventory.tree[3] == "2");
  CHECK(inventory.dbh_cm == std::vector<double>{20, 12, 8, 20});
  CHECK(has_note(checked, "2 trees have the number of another tree of the same plot"));
  CHECK(has_note(checked,
                 "2 of these stand at the position of the other tree, as stems of one stool do"));
}

TEST_CASE("a tree that was measured again in another year is the same tree") {
  // Two stems of one stool in 2000, both measured again in 2010; a tree of one year; a number that
  // was given to a tree elsewhere.
  const std::string rows =
      ",plot,tree,x,y,dbh\n"
      "2000,1,1,1,1,20\n"
      "2000,1,1,1,1,12\n"
      "2010,1,1,1,1,24\n"
      "2010,1,1,1,1,15\n"
      "2000,1,2,5,5,20\n"
      "2010,1,2,9,9,21\n";
  const std::vector<std::string> expected{"2 tree: the plot was measured again: 2010",
                                          "3 tree: the plot was measured again: 2010",
                                          "6 tree: the plot was measured again: 2010"};
  for (const char* column : {"year", "Year", "date"}) {
    const CheckedInventory checked = read_inventory_text(column + rows);
    CHECK(problems(checked) == expected);
    CHECK(checked.inventory.dbh_cm == std::vector<double>{24, 15, 21});
    CHECK(has_note(checked, "1 of these stands at the position of the other tree"));
  }
  CHECK(problems(read_inventory_text("Zeit" + rows, with_columns("year=Zeit"))) == expected);
  // Without a time they could be stems of one stool, as the note states.
  const CheckedInventory unknown = read_inventory_text("Zeit" + rows);
  CHECK(unknown.inventory.size() == 6);
  CHECK(has_note(unknown, "`columns=year=COLUMN`"));
}

TEST_CASE("a tree without a position that was measured again is counted once") {
  const std::string rows =
      ",plot,tree,dbh,h\n"
      "2010,1,1,20,15\n"
      "2010,1,2,30,18\n"
      "2010,1,3,10,9\n"
      "2015,1,1,22,16\n"
      "2015,1,2,33,19\n"
      "2015,1,3,11,10\n"
      "2015,1,4,8,7\n";
  const CheckedInventory checked = read_inventory_text("year" + rows);
  CHECK(checked.inventory.dbh_cm == std::vector<double>{22, 33, 11, 8});
  CHECK(problems(checked) == std::vector<std::string>{"2 tree: the plot was measured again: 2015",
                                                      "3 tree: the plot was measured again: 2015",
                                                      "4 tree: the plot was measured again: 2015"});
  CHECK_FALSE(has_note(checked, "year=COLUMN"));
  CHECK(has_note(checked, "the last visit is used (plot 1: 2015), 3 rows of earlier ones are"));
  CHECK(has_note(checked, "a `period` models"));
  const CheckedInventory unknown = read_inventory_text("Zeit" + rows);
  CHECK(unknown.inventory.size() == 7);
  CHECK_FALSE(has_note(unknown, "`period`"));
  CHECK(has_note(
      unknown, "3 of these have no position; the column Zeit tells them apart: if they are later"));
  // Two trees of one number and one time are two.
  const CheckedInventory one_time =
      read_inventory_text("plot,tree,dbh,year\n1,1,20,2010\n1,1,21,2010\n");
  CHECK(one_time.inventory.size() == 2);
  CHECK_FALSE(has_note(one_time, "year=COLUMN"));
}

TEST_CASE("a tree whose position was surveyed again within a visit is counted once") {
  const CheckedInventory checked = read_inventory_text(
      "date,plot,tree,x,y,dbh\n"
      "2015-06-01,1,1,1,1,20\n"
      "2015-06-08,1,1,1.02,0.99,22\n"  // surveyed again, across a line of whole meters
      "2015-06-15,1,1,,,24\n"          // and then not at all
      "2015-06-01,1,2,5,5,30\n"
      "2015-06-01,1,2,5.5,5,30\n"  // of the same day: another tree with this number
      "2015-06-08,1,2,5.4,5,31\n"  // that one again
      "2015-06-08,1,2,7,5,32\n");  // elsewhere: a third one
  CHECK(checked.inventory.dbh_cm == std::vector<double>{20, 30, 30, 32});
  CHECK(problems(checked) ==
        std::vector<std::string>{"3 tree: the same tree is on line 2, measured at another time",
                                 "4 tree: the same tree is on line 2, measured at another time",
                                 "7 tree: the same tree is on line 6, measured at another time"});
}

TEST_CASE("stems of one tree with equal dbh are two stems if a column numbers them") {
  const std::string rows = "1,1,1,1,1,12\n1,1,2,1,1,12\n1,1,2,1,1,12\n";
  for (const char* column : {"stem", "Fuste", "Trunk", "StemTag"}) {
    const CheckedInventory checked =
        read_inventory_text(std::string("plot,tree,") + column + ",x,y,dbh\n" + rows);
    CHECK(problems(checked) == std::vector<std::string>{"4 tree: the same tree is on line 3"});
    CHECK(checked.inventory.tree[1] == "1#2");
  }
  CHECK(read_inventory_text("plot,tree,remark,x,y,dbh\n" + rows).inventory.size() == 1);
}

TEST_CASE("a position of zeros or nines far from all others is asked about") {
  // Twelve trees on 30 m x 20 m, in UTM coordinates or from a corner of the plot.
  const auto rows = [](double east, double north) {
    std::string text = "plot,tree,x,y,dbh\n";
    for (int i = 0; i < 12; ++i) {
      text += fmt::format("1,{},{},{},20\n", i, east + 10 * (i % 4), north + 10 * (i / 4));
    }
    return text;
  };
  const std::string utm = rows(441000, 5412000);
  for (const char* code : {"0,0", "-999,-999", "-99,-99", "9999,9999"}) {
    CHECK_THROWS_WITH(read_inventory_text(utm + "1,12," + std::string(code) + ",20\n"),
                      Contains("from the other trees of the plot, which are at most 36.1 m"));
  }
  CHECK_THROWS_WITH(read_inventory_text(rows(0, 0) + "1,12,-999,-999,20\n"),
                    Contains("the position (-999, -999) is 1.41e+03 m"));
  CHECK(read_inventory_text(rows(0, 0) + "1,12,0,9,20\n").inventory.size() == 13);
  CHECK(read_inventory_text(rows(5, 5) + "1,12,0,0,20\n").inventory.size() == 13);
  InventoryOptions trusting;
  trusting.trust_units = true;
  CHECK(read_inventory_text(utm + "1,12,0,0,20\n", trusting).inventory.size() == 13);
}

TEST_CASE("a tally is not taken for trees, nor rows of sums and means") {
  const std::string tally = "plot,species,dbh,count\n1,A,12,14\n1,A,14,16\n";
  CHECK_THROWS_WITH(read_inventory_text(tally),
                    Contains("column count may be the number of trees"));
  CHECK(read_inventory_text(tally, with_columns("tree=count")).inventory.size() == 2);
  InventoryOptions trusting;
  trusting.trust_units = true;
  CHECK(read_inventory_text(tally, trusting).inventory.size() == 2);
  for (const std::string name : {"num_stems", "No. of stems", "Nombre", "N_ST"}) {
    CHECK_THROWS_WITH(read_inventory_text("plot," + name + ",dbh\n1,14,12\n1,16,14\n"),
                      Contains("may be the number of trees"));
  }
  // A name that counts trees needs no majority.
  for (const std::string name : {"number_of_trees", "individuals", "Baumzahl"}) {
    CHECK_THROWS_WITH(
        read_inventory_text("plot,tree," + name + ",dbh\n1,1,1,20\n1,2,1,22\n1,3,40,12\n"),
        Contains("the column " + name + " may be the number of trees"));
  }
  // Rows may be numbered, too; one tree a row is no tally.
  const std::string numbered = "plot,Nr,species,dbh,Stammzahl\nA,1,Fi,20,300\nA,2,Fi,30,110\n";
  CHECK_THROWS_WITH(read_inventory_text(numbered), Contains("column Stammzahl may be the number"));
  CHECK(read_inventory_text("plot,dbh,Count\n1,20,1\n1,22,1\n").inventory.size() == 2);
  // Stems of a tree.
  CHECK(read_inventory_text("plot,tree,dbh,n\n1,1,20,1\n1,2,22,3\n").inventory.size() == 2);
  InventoryOptions expanded;
  expanded.has_expansion = true;
  CHECK(read_inventory_text(tally, expanded).inventory.size() == 2);
  const CheckedInventory sums = read_inventory_text(
      "plot,tree,species,dbh\n1,1,A,20\n1,Mean,A,22\n1,2,MAX,24\n2,1,Total,40\nSumme,,,44\n");
  // MAX may be the code of a species.
  CHECK(sums.inventory.dbh_cm == std::vector<double>{20, 24});
  CHECK(problems(sums).front() == "3 tree: a row of sums or means is not a tree");
}

TEST_CASE("a value far above the next one may lack its decimal point") {
  std::string rows = "plot,tree,dbh,h\n1,1,28.6,20\n1,2,35,22\n";
  CHECK_FALSE(has_note(read_inventory_text(rows + "1,3,286,25\n"), "decimal point"));
  for (int tree = 4; tree < 12; ++tree) rows += fmt::format("1,{},{},12\n", tree, 10 + tree);
  CHECK_FALSE(has_note(read_inventory_text(rows + "1,3,80,25\n"), "decimal point"));
  CHECK(has_note(read_inventory_text(rows + "1,3,286,25\n"),
                 "286 cm is 8.2 times the next largest value, 35; is a decimal point missing?"));
}

TEST_CASE("plots that are numbered within clusters are named") {
  for (const char* const unit : {"cluster", "Trakt", "Bestand", "site"}) {
    CHECK(has_note(read_inventory_text(std::string(unit) + ",plot,tree,dbh\nA,1,1,20\nB,1,2,22\n"),
                   "1 plot label occurs with several values of the column " + std::string(unit)));
  }
  CHECK_FALSE(has_note(
      read_inventory_text("Bestand,cluster,plot,tree,dbh\nA,A,1,1,20\nA,B,2,2,22\n"), "occurs"));
}

TEST_CASE("a tree far from all others of its plot is an error") {
  std::string rows = "plot,tree,x,y,dbh\n";
  for (int tree = 1; tree < 13; ++tree) {
    rows += fmt::format("1,{},{},{},20\n", tree, tree % 4 * 5, tree / 4 * 5);
  }
  CHECK_THROWS_WITH(
      read_inventory_text(rows + "1,13,11230,5,20\n"),
      Contains("the tree at (11230, 5) is 1.12e+04 m from the other trees of its plot"));
  // As far as the others are apart, 15 and 15 m.
  CHECK(read_inventory_text(rows + "1,13,36,5,20\n").inventory.size() == 13);
  InventoryOptions trusting;
  trusting.trust_units = true;
  CHECK(read_inventory_text(rows + "1,13,11230,5,20\n", trusting).inventory.size() == 13);
}

TEST_CASE("a crown width that contradicts the radii is named") {
  const std::string header = "plot,tree,dbh,cw,cr_e,cr_w,cr_s,cr_n\n";
  CHECK(has_note(read_inventory_text(header + "1,1,20,5,1,1,1,1\n1,2,20,5,2,3,2,3\n"),
                 "1 tree has a cw that contradicts the four radii, which make more than twice or "
                 "less than half of it (line 2: 5 m, radii 2 m)"));
  CHECK_FALSE(has_note(read_inventory_text(header + "1,1,20,4,1,1,1,1\n"), "contradicts"));
}

TEST_CASE("columns of distances without directions are no positions") {
  const CheckedInventory trees =
      read_inventory_text("plot,tree,dbh,Abstand,Distanz\n1,1,20,3,4\n1,2,22,4,5\n");
  CHECK_FALSE(trees.inventory.has_coordinates());
}

TEST_CASE("a plot is described by its last visit") {
  // Plot 1: tree 2 died before 2020, tree 4 grew in; plot 2 was measured in 2018 only.
  const std::string header = "plot,tree,species,dbh,year,status\n";
  const std::string early = "1,1,A,20,2010,alive\n1,2,A,30,2010,alive\n1,3,A,10,2010,alive\n";
  const std::string late = "1,3,A,14,2020,alive\n1,1,A,25,2020,alive\n1,4,A,8,2020,alive\n";
  const std::string other = "2,1,A,40,2018,alive\n";
  for (const std::string& rows : {early + late + other, late + other + early}) {
    const CheckedInventory checked = read_inventory_text(header + rows);
    CHECK(checked.inventory.dbh_cm == std::vector<double>{14, 25, 8, 40});
    CHECK(has_note(checked,
                   "1 plot was measured several times: the last visit is used (plot 1: 2020), 3 "
                   "rows of earlier ones are skipped, and 1 tree of the visit before it that has "
                   "no row of it is gone"));
    CHECK(
        has_note(checked,
                 "1 plot was measured only before the last visits of these (plot 2) and counts as "
                 "of the same time"));
  }
  // A last visit that found dead trees only is the last one, too.
  const CheckedInventory dead =
      read_inventory_text(header + early + "1,1,A,20,2020,dead\n1,2,A,30,2020,cut\n" + other);
  CHECK(dead.inventory.dbh_cm == std::vector<double>{40});
  // A tree whose last row is invalid was found there.
  const CheckedInventory invalid =
      read_inventory_text(header + early + late + "1,2,A,x,2020,alive\n");
  CHECK(invalid.inventory.dbh_cm == std::vector<double>{14, 25, 8});
  CHECK_FALSE(has_note(invalid, "is gone"));
}

TEST_CASE("times of a plot are several visits if trees come again after a quarter of a year") {
  const auto dbh_of = [](const std::string& rows) {
    return read_inventory_text("plot,tree,dbh,date\n" + rows).inventory.dbh_cm;
  };
  using Sizes = std::vector<double>;
  // One campaign, two trees of it measured again as a control.
  CHECK(dbh_of("1,1,20,2019-06-30\n1,2,21,2019-07-02\n1,3,22,2019-07-02\n1,1,20.1,2019-07-09\n") ==
        Sizes{20, 21, 22});
  // Days in other orders, numbers of visits, and years beside days.
  CHECK(dbh_of("1,1,20,30.06.2019\n1,1,24,02.05.2023\n") == Sizes{24});
  CHECK(dbh_of("1,1,20,5/6/2019\n1,1,24,4/30/2023\n") == Sizes{24});
  CHECK(dbh_of("1,1,24,2\n1,1,20,1\n") == Sizes{24});
  CHECK(dbh_of("1,1,20,20120127\n1,1,24,20170127\n1,2,30,20170209\n") == Sizes{24, 30});
  CHECK(dbh_of("1,1,20,2019\n1,2,21,2019-11-30\n1,2,22,2020-10-01\n") == Sizes{22});
  // A tree that is new was measured a week before the others came again.
  CHECK(dbh_of("1,1,20,2015-07-29\n1,2,21,2015-07-29\n1,9,8,2016-07-21\n1,1,21,2016-07-29\n"
               "1,2,22,2016-07-29\n") == Sizes{8, 21, 22});
  // Winter of two years, where no tree comes again; a note says so.
  const CheckedInventory winter =
      read_inventory_text("plot,tree,dbh,year\n1,1,20,2019\n1,2,21,2020\n");
  CHECK(winter.inventory.dbh_cm == Sizes{20, 21});
  CHECK(has_note(winter,
                 "1 plot has rows of several times, but no tree comes again (plot 1: 2019 and "
                 "2020): all are used as of one visit"));
  // Plots of other places with the same label and numbers of trees.
  const std::string places = "plot,tree,x,y,dbh,year\n1,1,1,1,20,2019\n1,1,7,7,24,";
  CHECK(read_inventory_text(places + "2020\n").inventory.dbh_cm == Sizes{20, 24});
  CHECK_THROWS_WITH(read_inventory_text(places + "2023\n"),
                    Contains("no tree comes again (plot 1: 2019 and 2023)"));
  // Sample trees of many years without plots are of no visit.
  CHECK(read_inventory_text("dbh,year\n20,2009\n24,2023\n").inventory.dbh_cm == Sizes{20, 24});
  // Other names of the time; the century of 98 is not known.
  for (const char* name : {"Jahr", "INVYR", "census", "survey_year"}) {
    CHECK(read_inventory_text(std::string("plot,tree,dbh,") + name + "\n1,1,20,1\n1,1,24,2\n")
              .inventory.dbh_cm == Sizes{24});
  }
  CHECK_THROWS_WITH(dbh_of("1,1,20,98\n1,1,24,08\n"), Contains("measured again at 98"));
  CHECK_THROWS_WITH(dbh_of("1,1,20,12.06.98\n1,1,24,12.06.08\n"), Contains("measured again at"));
  CHECK_THROWS_WITH(dbh_of("1,1,20,spring\n1,1,24,autumn\n"),
                    Contains("trees of spring were measured again at autumn"));
}

TEST_CASE("labels of a file with decimal commas keep their commas") {
  const CheckedInventory checked = read_inventory_text(
      "plot;tree;species;x;y;dbh\n1,2;3,1;A;0,5;1;12,5\n1.2;\"3,1\";A;2,5;1;13,5\n");
  const Inventory& inventory = checked.inventory;
  CHECK(inventory.plot.levels() == std::vector<std::string>{"1,2", "1.2"});
  CHECK(inventory.tree[0] == "3,1");
  CHECK(inventory.tree[1] == "3,1");
  CHECK(inventory.x == std::vector<double>{0.5, 2.5});
  CHECK(inventory.dbh_cm == std::vector<double>{12.5, 13.5});
}

TEST_CASE("missing-value codes in coordinates give no position") {
  const std::string text =
      "plot,tree,species,x,y,z,dbh\n1,1,A,-9999,1,5,10\n1,2,A,-999,-10000,5,10\n"
      "1,3,A,1,-99999,5,10\n1,4,A,1,1,-9999,10\n";
  const CheckedInventory checked = read_inventory_text(text, {.needs_coordinates = true});
  CHECK(checked.inventory.x == std::vector<double>{-999, 1});
  CHECK(std::isnan(checked.inventory.z[1]));
  CHECK(problems(checked) ==
        std::vector<std::string>{"2 x: is missing, so the tree has no position",
                                 "4 y: is missing, so the tree has no position"});
  CHECK(has_note(checked, "codes read as missing values: x 1 (-9999), y 1 (-99999), z 1 (-9999)"));
  CHECK(read_inventory_text(text).inventory.size() == 4);
}

TEST_CASE("impossibly large coordinates are refused") {
  const CheckedInventory checked = read_inventory_text(
      "plot,tree,species,x,y,dbh\n1,1,A,1e9,-1e9,10\n1,2,A,1.1e9,1,10\n1,3,A,1,-1e300,10\n");
  CHECK(checked.inventory.x == std::vector<double>{1e9});
  CHECK_THAT(problems(checked).at(0), Contains("3 x: 1100000000 m is further than 1000000000 m"));
}

TEST_CASE("columns are named by mappings, expressions included") {
  const CheckedInventory checked = read_inventory_text(
      "Plot,Nr.,sp,xk,yk,D (cm),unit,height,age\n"
      "A,1,SM,53,54,20.3,m,18,70\n"
      "A,2,SM,57,93,10.7,cm,950,NA\n",
      with_columns("tree=Nr.,species=sp,x=xk/10,y=min(yk, 1000)/10,dbh=D (cm),"
                   "h=ifelse(unit == \"cm\", height/100, height),years=age,decade=age/10,z=100"));
  const Inventory& inventory = checked.inventory;
  REQUIRE(inventory.size() == 2);
  CHECK(inventory.plot[0] == "A");
  CHECK(inventory.x == std::vector<double>{5.3, 5.7});
  CHECK(inventory.y[1] == Approx(9.3).epsilon(1e-15));
  CHECK(inventory.dbh_cm[0] == 20.3);
  CHECK(inventory.h_m == std::vector<double>{18.0, 9.5});
  CHECK(inventory.z == std::vector<double>{100.0, 100.0});
  CHECK(inventory.other.numbers("years")[0] == 70.0);
  CHECK(inventory.other.numbers("decade")[0] == 7.0);
  CHECK(std::isnan(inventory.other.numbers("years")[1]));
  CHECK(has_note(checked, "plot is read from column Plot"));
}

TEST_CASE("other columns are kept on request, for the rows that are used") {
  const std::string text =
      "plot,tree,species,dbh,age,site\n1,1,SM,20,70,dry\n1,2,SM,-1,60,wet\n1,3,SM,20,NA,wet\n";
  const Inventory kept = read_inventory_text(text, {.keep = {"site", "dbh"}}).inventory;
  CHECK(kept.other.names() == std::vector<std::string>{"site"});
  CHECK(kept.other.text("site")[1] == "wet");

  const auto table = to_table(read_inventory_text(text, {.keep_all = true}).inventory);
  CHECK(table.names() == std::vector<std::string>{"plot", "tree", "species", "dbh", "age", "site"});
  CHECK(table.numbers("age")[0] == 70.0);
  CHECK(std::isnan(table.numbers("age")[1]));
  CHECK(table.line(1) == 4);
  CHECK_THROWS_AS(read_inventory_text(text, {.keep = {"slope"}}), InputError);
}

TEST_CASE("missing columns get defaults, with notes") {
  const CheckedInventory checked = read_inventory_text("DBH,H\n20,15\n30,20\n");
  CHECK(checked.inventory.plot[1] == "1");
  CHECK(checked.inventory.tree[1] == "2");
  CHECK(checked.inventory.species[1] == "unknown");
  CHECK(has_note(checked, "dbh is read from column DBH"));
  CHECK(has_note(checked, "no column plot"));
  CHECK(has_note(checked, "no column tree"));
  CHECK(has_note(checked, "no column species"));
}

TEST_CASE("a missing crown width is computed from four radii") {
  const CheckedInventory checked = read_inventory_text(
      "plot,tree,species,dbh,cw,cr_e,cr_w,cr_s,cr_n\n"
      "1,1,SM,20,NA,1,2,1.5,0\n"
      "1,2,SM,20,5,1,2,1.5,0\n"
      "1,3,SM,20,NA,1,2,1.5,NA\n"
      "1,4,SM,20,NA,0,0,0,0\n"
      "1,5,SM,20,NA,1,-2,1,1\n");
  REQUIRE(checked.inventory.size() == 4);
  CHECK(checked.inventory.cw_m[0] == 2.25);
  CHECK(checked.inventory.cw_m[1] == 5.0);
  CHECK(std::isnan(checked.inventory.cw_m[2]));
  CHECK(std::isnan(checked.inventory.cw_m[3]));
  CHECK(problems(checked) == std::vector<std::string>{"6 cr_w: -2 m is not 0 m or more"});
  CHECK(has_note(checked, "four crown radii"));
  CHECK(has_note(checked, "cr_e 1 (0), cr_w 1 (0), cr_s 1 (0), cr_n 1 (0)"));
}

TEST_CASE("a whole column in another unit is an error with its remedy") {
  const auto remedy = [](const std::string& column, double factor, const std::string& text) {
    INFO(column << " times " << factor);
    CHECK_THROWS_AS(read_inventory_text(stand_with(column, factor)), InputError);
    CHECK_THROWS_WITH(read_inventory_text(stand_with(column, factor)), Contains(text));
    CHECK_NOTHROW(read_inventory_text(stand_with(column, factor), {.trust_units = true}));
  };
  CHECK_NOTHROW(read_inventory_text(stand_with("", 1.0)));
  remedy("h", 100.0, "in centimeters, use `columns=h=h/100`");
  remedy("h", 1.0 / 0.3048, "in feet, use `columns=h=h*0.3048`");
  remedy("h", 1000.0, "in millimeters, use `columns=h=h/1000`");
  remedy("h", 10.0, "in decimeters, use `columns=h=h/10`");
  remedy("dbh", 10.0, "in millimeters, use `columns=dbh=dbh/10`");
  remedy("dbh", 0.01, "in meters, use `columns=dbh=dbh*100`");
  remedy("cw", 100.0, "in centimeters, use `columns=cw=cw/100`");
  remedy("cw", 10.0, "in decimeters, use `columns=cw=cw/10`");
  remedy("y", 0.0, "on one point or line");
  CHECK_THROWS_WITH(read_inventory_text(stand_with("hcb", 100.0)),
                    Contains("swapped, or in different units"));
  CHECK_THROWS_WITH(read_inventory_text(stand_with("h", 1000.0), with_columns("h=h/10")),
                    Contains("use `columns=h=(h/10)/100`"));
  CHECK_THROWS_WITH(
      read_inventory_text("dbh,H [old]\n20,1500\n21,1600\n", with_columns("h=H [old]")),
      Contains("use `columns=h=`H [old]`/100`"));
}

TEST_CASE("saplings, giants and sparse woods pass the check of units") {
  CHECK_NOTHROW(read_inventory_text("dbh,h\n0.5,1.6\n0.7,1.9\n0.4,1.5\n"));
  CHECK_NOTHROW(read_inventory_text("dbh,h\n400,85\n520,90\n350,78\n"));
  CHECK_NOTHROW(read_inventory_text("dbh\n30\n40\n"));
}

TEST_CASE("NA says that a table has no column of a standard name") {
  const char* const text = "X,Y,dbh,n,year\n-123.1,44.1,20,1,1\n-123.1,44.1,30,2,1\n";
  const CheckedInventory checked =
      read_inventory_text(text, {.columns = parse_column_mappings("x=NA,y=NA,year=NA,tree=n")});
  CHECK_FALSE(checked.inventory.has_coordinates());
  CHECK(checked.inventory.tree[1] == "2");
  CHECK(checked.inventory.time.size() == 0);
  CHECK_THROWS_WITH(read_inventory_text(text), Contains("`columns=tree=n`"));
}

TEST_CASE("the unit of sizes that no tree has is offered") {
  CHECK_THROWS_WITH(read_inventory_text("dbh,h\n149,118\n133,107\n180,151\n"),
                    Contains("if it is in dm, use `columns=h=h/10`"));
}

TEST_CASE("a size that no tree has is refused, and a note if units are trusted") {
  const char* const text = "plot,tree,dbh,h\n7,1,20,15\n7,2,21,160\n7,3,22,16\n";
  CHECK_THROWS_WITH(read_inventory_text(text),
                    Contains("160 m is more than any tree has (120 m), in 1 of 3 rows") &&
                        Contains(":3: h: ") && Contains("plot 7, tree 2"));
  const CheckedInventory checked = read_inventory_text(text, {.trust_units = true});
  CHECK(checked.inventory.size() == 3);
  CHECK(has_note(checked, ":3: h: 160 m is odd (plot 7, tree 2)"));
}

TEST_CASE("a file without needed columns is refused with the remedy") {
  CHECK_THROWS_WITH(
      read_inventory_text("plot,shoots\n1,20\n"),
      Contains("no column dbh (diameter at breast height in cm) was found; name it with "
               "`columns=dbh=COLUMN`; available: plot, shoots"));
  CHECK_THROWS_WITH(read_inventory_text("dbh,x\n20,1\n", {.needs_coordinates = true}),
                    Contains("no column y"));
  CHECK_THROWS_WITH(read_inventory_text("dbh\n20\n", {.needs = {"hcb"}}),
                    Contains("no column hcb"));
  CHECK_NOTHROW(read_inventory_text("dbh,cr_e,cr_w,cr_s,cr_n\n20,1,1,1,1\n", {.needs = {"cw"}}));
  CHECK_THROWS_WITH(read_inventory_text("dbh,h\n"), Contains("the file has a header but no trees"));
  CHECK_THROWS_WITH(read_inventory_text("dbh,h\n-1,5\nx,5\n"),
                    Contains("no usable row: 2 of 2 rows skipped, 2 problems") &&
                        Contains("'x' is not a number"));
  CHECK_THROWS_WITH(read_inventory_text("DBH,Dbh\n1,2\n"),
                    Contains("'DBH' and 'Dbh' could both be dbh"));
}

TEST_CASE("mappings are read, and invalid ones are refused") {
  const auto mappings =
      parse_column_mappings(" dbh = D , h=min(a, b),s=ifelse(u == \"a,b\", 1, 2)");
  REQUIRE(mappings.size() == 3);
  CHECK(mappings[0].name == "dbh");
  CHECK(mappings[0].source == "D");
  CHECK(mappings[1].source == "min(a, b)");
  CHECK(parse_column_mappings("h=`H, m`/10,x=X")[0].source == "`H, m`/10");
  CHECK(parse_column_mappings("").empty());
  for (const char* text : {"dbh", "dbh=", "=D", "dbh=D,", "dbh==D"}) {
    CHECK_THROWS_WITH(parse_column_mappings(text), Contains("is not NAME=COLUMN"));
  }
  CHECK_THROWS_WITH(parse_column_mappings("h=a,h=b"), Contains("'h' is given twice"));
  CHECK_THROWS_WITH(read_inventory_text("dbh\n20\n", with_columns("h=Height")),
                    Contains("unknown column 'Height' in h=Height; available: dbh"));
  CHECK_THROWS_AS(read_inventory_text("dbh\n20\n", with_columns("h=dbh+")), silvafit::FormulaError);
  CHECK_THROWS_WITH(read_inventory_text("dbh\n20\n", with_columns("plot=dbh/10")),
                    Contains("plot must be a column"));
}

TEST_CASE("the Finnish stands need mapped columns and units, and lose one row of 9913",
          "[reference]") {
  const auto file = silvafit::test::reference_data("spati.csv");
  InventoryOptions options = with_columns("tree=puunro,species=pl,dbh=d,x=xk,y=yk");
  options.needs_coordinates = true;
  CHECK_THROWS_WITH(read_inventory(file, options), Contains("use `columns=x=xk/10,y=yk/10`"));
  options.columns = parse_column_mappings("tree=puunro,species=pl,dbh=d,x=xk/10,y=yk/10");
  const CheckedInventory checked = read_inventory(file, options);
  CHECK(checked.inventory.size() == 9912);
  CHECK(checked.excluded_tree_count == 1);
  CHECK(has_note(checked, "131 trees have the number of another tree"));
}
