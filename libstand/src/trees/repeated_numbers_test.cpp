// SPDX-License-Identifier: MIT
// What rows with the number of another tree are. Trees were counted by hand.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "test_support/inventory_test_support.hpp"

using namespace silvafit;
using namespace silvafit::stand;
using Catch::Contains;

namespace {

std::size_t trees_in(const std::string& text, const InventoryOptions& options = {}) {
  return read_inventory_text(text, options).inventory.size();
}

/// Twelve trees of one species in one plot, at two "times" or in two "parts" of a column.
std::string twice(const char* column, bool are_same_trees) {
  std::string text = fmt::format("plot,tree,species,dbh,{}\n", column);
  Random random(5);
  for (int tree = 1; tree <= 12; ++tree) {
    const double first = random.uniform(8.0, 40.0);
    const double second = are_same_trees ? first + 1.5 : random.uniform(8.0, 40.0);
    text += fmt::format("1,{0},Picea,{1:.1f},A\n1,{0},Picea,{2:.1f},B\n", tree, first, second);
  }
  return text;
}

/// Twelve pines and twelve oaks with the same numbers, measured at three times.
std::string pines_and_oaks() {
  std::string text = "plot,tree,species,dbh,campaign_no\n";
  Random random(5);
  for (int tree = 1; tree <= 12; ++tree) {
    for (const char* const species : {"Pinus", "Quercus"}) {
      const double dbh = random.uniform(8.0, 40.0);
      for (int time = 0; time < 3; ++time) {
        text += fmt::format("1,{},{},{:.1f},{}\n", tree, species, dbh + time, time);
      }
    }
  }
  return text;
}

/// The table with one year in all rows.
std::string with_year(std::string text, const char* value = ",2020") {
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 1)) {
    const std::string year = at == text.find('\n') ? ",year" : value;
    text.insert(at, year);
    at += year.size();
  }
  return text;
}

}  // namespace

TEST_CASE("rows that differ in any column are different trees, equal ones are copies") {
  CHECK(trees_in("plot,tree,species,dbh\n1,1,Picea,20\n1,1,Fagus,20\n1,2,Picea,22\n") == 3);
  CHECK(trees_in("plot,sub,tree,species,dbh\n1,N,1,Picea,20\n1,S,1,Picea,20\n1,S,2,Picea,22\n") ==
        3);
  CHECK(trees_in("plot,tree,dbh,remark\n1,1,20,\n1,1,20,fork\n") == 2);
  CHECK(trees_in("plot,tree,species,dbh\n1,1,Picea,20\n1,1,Picea,20\n1,2,Picea,22\n") == 2);
  CHECK(trees_in("plot,tree,dbh\n1,1,20\n1,1,15\n1,2,30\n1,1,20\n1,1,15\n1,2,30\n") == 3);
  // At one place of one species, it is one tree whatever else was noted.
  CHECK(trees_in("plot,tree,species,x,y,dbh,remark\n1,1,Picea,2,3,20,\n1,1,Picea,2,3,20,fork\n") ==
        1);
  CHECK(trees_in("plot,tree,species,x,y,dbh\n1,1,Picea,2,3,20\n1,1,Fagus,2,3,20\n") == 2);
}

TEST_CASE("trees without a number of their own are not copies") {
  CHECK(trees_in("plot,tree,dbh\n1,0,8\n1,0,8\n1,0,8\n1,0,9\n1,17,30\n") == 5);
  CHECK(trees_in("plot,tree,dbh\n1,0,8\n1,0,8\n") == 2);
  CHECK(trees_in("plot,tree,dbh\n1,untagged,8\n1,untagged,8\n1,untagged,9\n1,untagged,9\n"
                 "1,untagged,9\n1,17,30\n") == 6);
}

TEST_CASE("trees that come again with nearly the same dbh need a time") {
  const std::string again = twice("campaign_no", true);
  CHECK_THROWS_WITH(read_inventory_text(again),
                    Contains("12 trees of one number and species have several rows") &&
                        Contains("the column campaign_no tells them apart") &&
                        Contains("`columns=year=campaign_no`"));
  CHECK(trees_in(again, {.trust_units = true}) == 24);
  // A column that has one time only is not that of the measurements.
  CHECK_THROWS_WITH(
      read_inventory_text(with_year(twice("date", true))),
      Contains("but the column year has one time for them; the column date tells them apart"));
  CHECK_THROWS_WITH(read_inventory_text(with_year(twice("date", true), ",")),
                    Contains("but the column year is empty; the column date tells them apart"));
  CHECK_THROWS_WITH(read_inventory_text(pines_and_oaks()), Contains("`columns=year=campaign_no`"));
  const CheckedInventory parts = read_inventory_text(twice("half", false));
  CHECK(parts.inventory.size() == 24);
  CHECK(has_note(parts, "`columns=tree=half+tree`"));
}

TEST_CASE("without numbers, equal rows at one position are told, and refused if most are copies") {
  const std::string trees = "1,2,20.5,P\n3,4,12.5,P\n5,9,14.5,P\n8,1,30.5,P\n";
  CHECK_THROWS_WITH(read_inventory_text("x,y,dbh,species\n" + trees + trees),
                    Contains("4 of 8 rows equal an earlier one in all columns"));
  CHECK(trees_in("x,y,dbh,species\n" + trees + trees, {.trust_units = true}) == 8);
  // Two equal stems of one stool, among twelve trees.
  std::string others;
  for (int i = 0; i < 8; ++i) others += fmt::format("{0},{0},{0}.5,P\n", 11 + i);
  const CheckedInventory stool =
      read_inventory_text("x,y,dbh,species\n" + trees + others + "8,1,30.5,P\n");
  CHECK(stool.inventory.size() == 13);
  CHECK(has_note(stool, "1 row equals an earlier one in all columns"));
  // Without positions, trees of a tally have equal values.
  CHECK(trees_in("dbh,species\n20,P\n20,P\n22,P\n22,P\n") == 4);
}

TEST_CASE("plots in several places of a file are named by the column that tells them apart") {
  const CheckedInventory farms = read_inventory_text(
      "estate,plot,tree,species,dbh\nA,1,1,P,20\nA,1,2,F,21\nA,2,3,P,22\nA,2,4,P,20\nB,1,5,F,20\n"
      "B,1,6,P,23\nB,2,7,P,20\nB,2,8,F,24\n");
  CHECK(has_note(farms,
                 "2 plot labels occur with several values of the column estate (1 occurs with "
                 "A and B)"));
  // A plot that was left and taken up again.
  const CheckedInventory again =
      read_inventory_text("crew,plot,tree,dbh\nA,1,1,20\nA,2,3,22\nA,1,5,20\n");
  CHECK_FALSE(has_note(again, "plot label"));
}

TEST_CASE("maps with an origin of their own are not one map") {
  std::string text = "unit,tree,x,y,dbh\n";
  for (int unit = 1; unit <= 2; ++unit) {
    for (int tree = 1; tree <= 12; ++tree) {
      text +=
          fmt::format("{},{},{},{},{}\n", unit, 100 * unit + tree, tree, tree * tree, 10 + tree);
    }
  }
  CHECK_THROWS_WITH(
      read_inventory_text(text),
      Contains("12 positions have several trees, most of which the column unit tells") &&
          Contains("`columns=plot=unit`"));
  CHECK(trees_in(text, {.trust_units = true}) == 24);
  // A few stools, whose stems a column tells apart by chance.
  const CheckedInventory stools = read_inventory_text(
      "quality,tree,x,y,dbh\n1,1,1,1,20\n2,2,1,1,21\n1,3,4,9,22\n2,4,4,9,23\n1,5,7,2,24\n");
  CHECK(stools.inventory.size() == 5);
}

TEST_CASE("labels that a spreadsheet has shortened are refused") {
  for (const char* const header : {"plot,tree,dbh", "tree,plot,dbh"}) {
    CHECK_THROWS_WITH(
        read_inventory_text(fmt::format("{}\n1.88785E+14,1,20\n1.88785E+14,2,21\n", header)),
        Contains("'1.88785E+14' is a number that a spreadsheet has shortened"));
  }
  CHECK(trees_in("plot,tree,dbh\nE+1,1,20\n1.5E+1,2,21\n") == 2);
}

TEST_CASE("headings and sums between the rows of a table are neither trees nor plots") {
  for (const char* const label : {"A Average",
                                  "A Max",
                                  "Total A",
                                  "Plot A total",
                                  "Mean A",
                                  "TOTAL PARCELA A",
                                  "Grand Average",
                                  "Subtotal plot A"}) {
    INFO(label);
    const CheckedInventory read =
        read_inventory_text(fmt::format("plot,tree,dbh\nA,1,20\nA,2,22\n{},,21\n", label));
    CHECK(read.inventory.size() == 2);
    CHECK(read.inventory.plots_left_out.empty());
  }
  CHECK_THROWS_WITH(
      trees_in("plot,tree,species,dbh\nA,1,P,20\n,,,\nPlot,n,,mean dbh\nA,1,,20\n"),
      Contains(":4: the line has 'mean dbh' in the column dbh") && Contains("file of its own"));
  // The same header again is only skipped.
  CHECK(trees_in("plot,tree,dbh\nA,1,20\nplot,tree,dbh\nA,2,21\n") == 2);
  CHECK_THROWS_WITH(trees_in("tree,species,dbh\nPlot A,,\n1,P,20\nPlot B,,\n2,P,30\n"),
                    Contains(":2: the line has only the text 'Plot A'"));
  CHECK(trees_in("tree,species,dbh\n1,P,20\n2,P,30\nSource: own survey,,\n") == 2);
  for (const char* const mark : {"\"\"\"\"", "do.", "''", "ditto"}) {
    CHECK_THROWS_WITH(trees_in(fmt::format("plot,tree,species,dbh\nA,1,P,20\nA,2,{},22\n", mark)),
                      Contains("stands for the one above it") && Contains("`fill_down=species`"));
  }
}

TEST_CASE("rows of sums and means are no trees in any language or phrase") {
  for (const char* const label : {"合計",
                                  "Yhteensä",
                                  "Medel",
                                  "Keskiarvo",
                                  "Średnia",
                                  "Celkem",
                                  "TOTAL PLOT 1",
                                  "Plot mean",
                                  "Mittelwert Plot 1",
                                  "mean dbh",
                                  "Sum of BA",
                                  "N/ha",
                                  "QMD",
                                  "Count",
                                  "n =",
                                  "Desvio padrão"}) {
    INFO(label);
    CHECK(trees_in(fmt::format("plot,tree,dbh\n1,1,20\n1,2,22\n1,{},42\n", label)) == 2);
  }
  for (const char* const label :
       {"n", "12a", "Old plot tree", "Sumac", "Meadow", "SE-1", "Somme 2", "Max 1"}) {
    INFO(label);
    CHECK(trees_in(fmt::format("plot,tree,dbh\n1,1,20\n1,2,22\n1,{},42\n", label)) == 3);
  }
}

TEST_CASE("numbers with marks of another kind are refused with their line") {
  for (const char* const number : {"\"1,020\"", "1'020", "1 020", "\"20,5\"", "\"1.020,5\""}) {
    INFO(number);
    CHECK_THROWS_WITH(read_inventory_text(fmt::format("plot,tree,dbh\n1,1,250\n1,2,{}\n", number)),
                      Contains(":3: dbh: ") && Contains("write decimals with a point"));
  }
  CHECK_THROWS_WITH(read_inventory_text("plot;tree;dbh\n1;1;20,5\n1;2;1.020,5\n"),
                    Contains("write decimals with a comma"));
}

TEST_CASE("the unit of a header may have a factor") {
  struct Case {
    const char* header;
    double cm;  ///< of 100
  };
  for (const auto& [header, cm] : {Case{"DBH (0.1 in)", 25.4},
                                   Case{"DBH (1/10 in)", 25.4},
                                   Case{"DBH (10ths in)", 25.4},
                                   Case{"DBH (tenths of inch)", 25.4},
                                   Case{"DBH (1/16 in)", 15.875},
                                   Case{"DBH (0.1 mm)", 1.0},
                                   Case{"\"DBH (0,1 mm)\"", 1.0},
                                   Case{"DBH (mm/10)", 1.0},
                                   Case{"DBH (0.1 cm)", 10.0},
                                   Case{"DBH (mm)", 10.0},
                                   Case{"DBH (cm at 1.3 m)", 100.0},
                                   Case{"DBH (cm)", 100.0}}) {
    INFO(header);
    const auto trees =
        read_inventory_text(fmt::format("plot,tree,{}\n1,1,100\n", header), {.trust_units = true});
    CHECK(trees.inventory.dbh_cm.front() == Approx(cm).epsilon(1e-5));
  }
  CHECK(read_inventory_text("plot,tree,DBH [x10 cm]\n1,1,3\n", {.trust_units = true})
            .inventory.dbh_cm.front() == Approx(30.0));
}

TEST_CASE("several trees at the place of a code stretch no plot") {
  std::string text = "plot,tree,azimuth,distance,dbh\n";
  for (int i = 0; i < 12; ++i) {
    text += fmt::format("1,{},{},{},20\n", i, 30 * i, 3 + i % 5);
  }
  CHECK(trees_in(text) == 12);
  CHECK_THROWS_WITH(read_inventory_text(text + "1,20,99,99,20\n1,21,99,99,21\n1,22,99,99,22\n"),
                    Contains("from the other trees of its plot"));
}
