// SPDX-License-Identifier: MIT
// Inventories read plot by plot.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/unit_summary.hpp"
#include "test_support/inventory_test_support.hpp"

using namespace silvafit::stand;
using Catch::Matchers::Contains;
using silvafit::test::ScratchFile;

namespace {

constexpr char kHeader[] = "plot,tree,species,x,y,dbh,cw\n";

/// Plots of 5 to 40 trees, some rows of which cannot be used.
std::string plots_csv(int plots) {
  silvafit::Random random(8);
  std::string text = kHeader;
  for (int plot = 1; plot <= plots; ++plot) {
    const auto trees = 5 + random.below(36);
    for (std::uint64_t tree = 1; tree <= trees; ++tree) {
      text += fmt::format("{},{},{},{:.2f},{:.2f},{:.1f},{:.2f}\n",
                          plot,
                          tree,
                          plot > plots / 2 && tree % 3 == 0 ? "late" : "early",
                          random.uniform(0, 20),
                          random.uniform(0, 20),
                          tree == 4 ? -1.0 : random.uniform(5, 40),
                          random.uniform(1, 5));
    }
  }
  return text;
}

std::string csv_of(const Inventory& inventory, bool with_header) {
  std::ostringstream stream;
  const StructuralUnits units = structural_units(inventory, {.edge = EdgeCorrection::kHanisch});
  write_structural_units(inventory, units, stream, with_header);
  return stream.str();
}

}  // namespace

TEST_CASE("an inventory read plot by plot has the same units as one read at once") {
  const ScratchFile file(plots_csv(60), ".csv");
  const CheckedInventory whole = read_inventory(file.path(), {.needs_coordinates = true});
  const std::string expected = csv_of(whole.inventory, true);
  UnitSummaries whole_summaries;
  const StructuralUnitOptions options;
  whole_summaries.add(whole.inventory, structural_units(whole.inventory, options));
  for (const std::size_t trees : {1UL, 50UL, 333UL, 100000UL}) {
    InventoryBatches batches(file.path(), {.needs_coordinates = true}, trees);
    std::string found;
    std::size_t count = 0;
    std::size_t excluded = 0;
    UnitSummaries summaries;
    while (const auto batch = batches.next()) {
      found += csv_of(batch->inventory, count == 0);
      summaries.add(batch->inventory, structural_units(batch->inventory, options));
      excluded += batch->excluded.size();
      ++count;
    }
    CHECK(found == expected);
    CHECK(excluded == whole.excluded.size());
    CHECK(excluded == 60);
    CHECK((trees == 1 ? count == 60 : count <= 60));
    CHECK(summaries.all().core_trees == whole_summaries.all().core_trees);
    // Sums of other batches are added in another order of the same rows: to the last digit alike.
    CHECK(summaries.all().M == whole_summaries.all().M);
    REQUIRE(summaries.by_species().size() == 2);
    CHECK(summaries.by_species()[1].species == "late");
    CHECK(summaries.by_species()[1].trees == whole_summaries.by_species()[1].trees);
  }
}

TEST_CASE("the notes on batches are those on the whole file") {
  // Plot 1 is outside of its window, 2 on one line, 3 has radii, odd and repeated trees; some rows
  // cannot be used.
  const ScratchFile file(
      "plot,tree,species,x,y,dbh,h,cr_e,cr_w,cr_s,cr_n\n"
      "1,1,A,90,1,10,5,,,,\n1,2,,91,1,10,5,,,,\n1,3,A,92,5,-1,5,,,,\n"
      "2,1,A,1,1,10,5,,,,\n2,2,A,2,1,10,5,,,,\n2,3,A,3,1,10,1,,,,\n"
      "3,1,A,1,1,10,150,2,2,2,2\n3,1,,8,8,12,130,2,2,2,2\n3,3,A,8,8,1200,20,,,,\n"
      "3,4,A,1,8,10,20,2,2,2,2\n",
      ".csv");
  const InventoryOptions reading{.needs_coordinates = true, .trust_units = true};
  const CheckedInventory whole = read_inventory(file.path(), reading);
  const NamedWindow square{kEveryPlot, Window::rectangle({0, 0}, {10, 10})};
  for (const bool is_hull : {false, true}) {
    for (const EdgeCorrection edge : {EdgeCorrection::kBuffer, EdgeCorrection::kNone}) {
      StructuralUnitOptions options{
          .neighbors = 1,
          .edge = edge,
          .buffer_m = 0.0,
          .further = {FurtherIndex::kHegyi, FurtherIndex::kBasalAreaLarger},
          .competition_radius_m = 3.0};
      if (!is_hull) options.windows = {square};
      const StructuralUnits at_once = structural_units(whole.inventory, options);
      CHECK(at_once.notes.size() >= 4);
      options.is_part = true;
      InventoryBatches batches(file.path(), reading, 1);
      UnitFindings findings;
      while (const auto batch = batches.next()) {
        const StructuralUnits part = structural_units(batch->inventory, options);
        CHECK(part.notes.empty());
        findings.add(part.findings);
      }
      CHECK(batches.notes() == whole.notes);
      CHECK(notes_of(findings, options, file.path()) == at_once.notes);
      CHECK(batches.excluded() == describe_excluded(whole));
    }
  }
}

TEST_CASE("skipped rows count for the size of a batch, which has whole plots of them") {
  std::string text = kHeader;
  for (int i = 0; i < 100; ++i) text += fmt::format("1,{},A,1,1,-1,1\n", i);
  for (int plot = 2; plot <= 4; ++plot) {
    for (int i = 0; i < 30; ++i)
      text += fmt::format("{},{},A,1,{},{},1\n", plot, i, i, i % 2 - 0.5);
  }
  const ScratchFile file(text, ".csv");
  const InventoryOptions options{.needs_coordinates = true, .trust_units = true};
  InventoryBatches batches(file.path(), options, 20);
  std::vector<ExcludedRow> excluded;
  std::size_t trees = 0;
  while (const auto batch = batches.next()) {
    // Plot 1 has 100 rows, none of which can be used; half of the 30 of each other plot can.
    CHECK(batch->excluded.size() == (batch->inventory.size() == 0 ? 100 : 15));
    excluded.insert(excluded.end(), batch->excluded.begin(), batch->excluded.end());
    trees += batch->inventory.size();
  }
  const CheckedInventory whole = read_inventory(file.path(), options);
  CHECK(trees == whole.inventory.size());
  REQUIRE(excluded.size() == whole.excluded.size());
  for (std::size_t i = 0; i < excluded.size(); ++i)
    CHECK(excluded[i].line == whole.excluded[i].line);
  CHECK(batches.excluded() == describe_excluded(whole));
  // With no tree at all the first rows are named, although they were in an earlier batch.
  const ScratchFile none(std::string(kHeader) + "1,1,A,1,1,-1,1\n2,1,A,1,1,-1,1\n", ".csv");
  InventoryBatches nothing(none.path(), options, 1);
  CHECK(nothing.next()->excluded.size() == 1);
  CHECK(nothing.next()->excluded.size() == 1);
  CHECK_THROWS_WITH(nothing.next(), Contains("2 of 2 rows skipped") && Contains(":2: dbh"));
}

TEST_CASE("it is an error if all trees of all batches are outside, not those of one") {
  const ScratchFile file(std::string(kHeader) + "1,1,A,90,1,10,1\n2,1,A,1,1,10,1\n", ".csv");
  const InventoryOptions reading{.needs_coordinates = true, .trust_units = true};
  const auto findings_in = [&](double side_m) {
    const StructuralUnitOptions options{
        .neighbors = 1,
        .is_part = true,
        .windows = {{kEveryPlot, Window::rectangle({0, 0}, {side_m, side_m})}}};
    InventoryBatches batches(file.path(), reading, 1);
    UnitFindings findings;
    while (const auto batch = batches.next()) {
      findings.add(structural_units(batch->inventory, options).findings);
    }
    return notes_of(findings, options, "trees.csv");
  };
  CHECK(findings_in(10.0).at(0) == "1 tree is outside the window: used only as neighbors");
  CHECK_THROWS_WITH(findings_in(0.5),
                    Contains("trees.csv") && Contains("between x 1 and 90, y 1 and 1 m"));
}

TEST_CASE("one window for plots of several batches is refused as for those of one") {
  const ScratchFile file(std::string(kHeader) + "1,1,A,2,1,10,1\n2,1,A,1,1,10,1\n", ".csv");
  StructuralUnitOptions options{.is_part = true,
                                .windows = {{std::nullopt, Window::rectangle({0, 0}, {9, 9})}}};
  InventoryBatches batches(file.path(), {.needs_coordinates = true, .trust_units = true}, 1);
  UnitFindings findings;
  while (const auto batch = batches.next()) {
    findings.add(structural_units(batch->inventory, options).findings);
  }
  CHECK_THROWS_WITH(notes_of(findings, options, ""), Contains("one window is given for 2 plots"));
}

TEST_CASE("plots whose rows are not contiguous are read whole, with the lines of the file") {
  const ScratchFile file(std::string(kHeader) + "1,1,A,1,1,10,1\n2,1,A,1,1,10,1\n1,2,A,1,2,10,1\n",
                         ".csv");
  const InventoryOptions options{.needs_coordinates = true, .trust_units = true};
  InventoryBatches batches(file.path(), options, 1);
  CHECK(batches.is_sorted());
  const auto first = batches.next();
  CHECK_FALSE(first->is_in_file_order);
  CHECK(first->inventory.lines == std::vector<std::uint32_t>{2, 4});
  const auto second = batches.next();
  CHECK(second->inventory.lines == std::vector<std::uint32_t>{3});
  CHECK_FALSE(batches.next());
  // Contiguous ones are read in the order of the file.
  const ScratchFile sorted(std::string(kHeader) + "1,1,A,1,1,10,1\n1,2,A,1,2,10,1\n", ".csv");
  InventoryBatches unsorted(sorted.path(), options, 1);
  CHECK_FALSE(unsorted.is_sorted());
  CHECK(unsorted.next()->is_in_file_order);
}

TEST_CASE("plots that several columns name are sorted, too, and whole") {
  const ScratchFile file("site,sub,tree,x,y,dbh\n1,2,1,1,1,10\n12,1,1,1,1,11\n1,2,2,1,2,12\n",
                         ".csv");
  const InventoryOptions options{.columns = {{"plot", "site+sub"}}, .trust_units = true};
  InventoryBatches batches(file.path(), options, 1);
  CHECK(batches.is_sorted());
  CHECK(batches.next()->inventory.dbh_cm == std::vector<double>{10, 12});
  CHECK(batches.next()->inventory.dbh_cm == std::vector<double>{11});
  CHECK_FALSE(batches.next());
}

TEST_CASE(
    "batches of rows are in the order of the file and not compared, and a table is one batch") {
  const ScratchFile file(
      std::string(kHeader) + "1,1,A,1,1,10,1\n2,1,a,1,1,11,1\n1,1,A,1,1,10,1\n1,2,A,,1,9,1\n",
      ".csv");
  const InventoryOptions options{.needs_coordinates = true, .trust_units = true};
  InventoryBatches rows(file.path(), options, 2, BatchOf::kRows);
  CHECK(rows.has_numbers());
  CHECK(rows.row_count() == 4);
  CHECK(rows.next()->inventory.dbh_cm == std::vector<double>{10, 11});
  CHECK(rows.rows()->lines == std::vector<std::size_t>{2, 3});
  const auto second = rows.next();
  CHECK(second->inventory.dbh_cm == std::vector<double>{10});
  CHECK(second->excluded.front().line == 5);
  CHECK_FALSE(rows.next());
  InventoryBatches table(file.path(), options, 1, BatchOf::kTable);
  const auto whole = table.next();
  CHECK(whole->inventory.size() == 2);
  CHECK(whole->notes == read_inventory(file.path(), options).notes);
  CHECK_FALSE(table.next());
}

TEST_CASE("without tree numbers, rows of a plot after another plot are an error with their line") {
  const ScratchFile file("plot,species,x,y,dbh\n1,A,1,1,10\n2,A,1,1,10\n1,A,1,2,10\n", ".csv");
  const InventoryOptions options{.needs_coordinates = true, .trust_units = true};
  InventoryBatches batches(file.path(), options, 1);
  CHECK(batches.next()->inventory.size() == 1);
  CHECK(batches.next()->inventory.size() == 1);
  CHECK_THROWS_WITH(batches.next(), Contains(":4: ") && Contains("sort the file by plot"));
  // Within one batch the order does not matter.
  InventoryBatches large(file.path(), options, 100);
  CHECK(large.next()->inventory.size() == 3);
  CHECK_FALSE(large.next());
  CHECK_FALSE(large.next());
}

TEST_CASE("batches have the times of their own rows") {
  const ScratchFile file(
      "plot,tree,x,y,dbh,year\n1,1,0,0,10,2000\n1,1,0,0,12,2010\n2,1,0,0,10,2000\n"
      "2,1,0,0,12,2000\n",
      ".csv");
  InventoryBatches batches(file.path(), {.trust_units = true}, 1);
  CHECK(batches.next()->inventory.size() == 1);
  CHECK(batches.next()->inventory.size() == 2);
}

TEST_CASE("a species with a limit angle of its own may come in a later batch") {
  const ScratchFile file(std::string(kHeader) +
                             "1,1,A,0,0,10,1\n1,2,A,0,2,10,1\n1,3,A,2.9,0.5,10,1\n"
                             "2,1,B,0,0,10,1\n2,2,A,0,2,10,1\n2,3,A,2.9,0.5,10,1\n",
                         ".csv");
  // Seen from tree 1 the neighbors are at right angles, less 9.8 degrees.
  StructuralUnitOptions options{.neighbors = 2,
                                .alpha0_deg = 90.0,
                                .alpha0_deg_of_species = {{"B", 60.0}},
                                .edge = EdgeCorrection::kNone};
  InventoryBatches batches(file.path(), {.trust_units = true}, 1);
  const Inventory first = batches.next()->inventory;
  CHECK_THROWS_WITH(structural_units(first, options), Contains("unknown species 'B'"));
  options.is_part = true;
  CHECK(structural_units(first, options).W[0] == 1.0);
  CHECK(structural_units(batches.next()->inventory, options).W[0] == 0.0);
  CHECK_NOTHROW(check_species_of_angles(options, {"A", "B"}, "trees.csv"));
  CHECK_THROWS_WITH(check_species_of_angles(options, {"A", "C"}, "trees.csv"),
                    Contains("trees.csv") && Contains("`alpha`") &&
                        Contains("unknown species 'B'; available: A, C"));
}

TEST_CASE("options that batches do not support are errors") {
  const ScratchFile empty(kHeader, ".csv");
  InventoryBatches batches(empty.path(), {}, 10);
  CHECK_THROWS_WITH(batches.next(), Contains("a header but no tree"));
  CHECK_THROWS_AS(InventoryBatches("/dev/null", {.columns = {{"age", "dbh"}}}), silvafit::Error);
  // Trees without a column of plots are all of one plot: one batch.
  const ScratchFile one("dbh,x,y\n10,1,1\n11,1,2\n", ".csv");
  InventoryBatches single(one.path(), {.trust_units = true}, 1);
  CHECK(single.next()->inventory.size() == 2);
}

TEST_CASE("other columns of batches have the types and values that they have in the whole file") {
  // The code is text in the last plot, so it is text in all; the age is a number. Rows cannot be
  // used, or repeat a tree, and the rows of plot 2 are not contiguous.
  const std::string rows =
      "2,1,A,0,0,10,1,07,50\n1,1,A,0,0,10,1,7,NA\n1,2,A,1,0,-1,1,08,51\n1,3,A,2,0,10,1,,52\n"
      "1,3,A,2,0,10,1,,52\n2,2,A,1,1,11,1,\"a,b\",53\n3,1,B,0,1,12,1,x,54\n";
  const ScratchFile file("plot,tree,species,x,y,dbh,cw,code,age\n" + rows, ".csv");
  const InventoryOptions options{
      .columns = {{"old", "age > 52"}}, .keep = {"code", "age"}, .trust_units = true};
  const CheckedInventory whole = read_inventory(file.path(), options);
  REQUIRE(whole.inventory.size() == 5);
  InventoryBatches batches(file.path(), options, 1);
  CHECK(batches.is_sorted());
  std::size_t trees = 0;
  while (const auto batch = batches.next()) {
    const Inventory& part = batch->inventory;
    for (std::size_t row = 0; row < part.size(); ++row, ++trees) {
      const auto found = std::ranges::find(whole.inventory.lines, part.lines[row]);
      REQUIRE(found != whole.inventory.lines.end());
      const auto same = static_cast<std::size_t>(found - whole.inventory.lines.begin());
      CHECK(part.other.text("code")[row] == whole.inventory.other.text("code")[same]);
      for (const char* const name : {"age", "old"}) {
        const double expected = whole.inventory.other.numbers(name)[same];
        const double value = part.other.numbers(name)[row];
        CHECK((value == expected || (std::isnan(value) && std::isnan(expected))));
      }
    }
  }
  CHECK(trees == 5);
}

TEST_CASE("a note names plots with one label in several stands, whole or plot by plot") {
  const auto csv = [](const std::string& column, const std::string& second) {
    std::string text = "plot," + column + ",tree,dbh\n";
    int tree = 0;
    for (const std::string& plot : {std::string("1"), std::string("2")}) {
      for (const std::string& stand : {std::string("N"), second}) {
        for (int i = 0; i < 2; ++i) text += fmt::format("{},{},{},20\n", plot, stand, ++tree);
      }
    }
    return text;
  };
  const std::string note =
      "2 plot labels occur with several values of the column STAND (1 occurs with N and S), but "
      "all trees with one plot label are treated as one plot; use plot labels that are unique in "
      "the file, such as N-1";
  const ScratchFile shared(csv("STAND", "S"));
  CHECK(read_inventory(shared.path()).notes.size() == 2);  // the other: there are no species
  CHECK(read_inventory(shared.path()).notes.back() == note);
  // Batches have one plot each; after the last the notes are the same.
  InventoryBatches batches(shared.path(), {}, 4);
  while (batches.next()) {
  }
  CHECK(batches.notes() == read_inventory(shared.path()).notes);
  // One stand, another column, an empty field, or the column being the plots themselves.
  const auto count = [](const std::string& text, const InventoryOptions& options) {
    const ScratchFile file(text);
    return read_inventory(file.path(), options).notes.size();
  };
  CHECK(count(csv("stand", "N"), {}) == 1);
  CHECK(count(csv("layer", "S"), {}) == 1);
  CHECK(count(csv("stand", ""), {}) == 1);
  CHECK(count(csv("stand", "S"), {.columns = {{"plot", "stand"}}}) == 1);
}

TEST_CASE("a repeated plot label may belong to another stand") {
  const ScratchFile file("plot,stand,dbh\n1,N,20\n2,N,20\n1,S,20\n");
  InventoryBatches batches(file.path(), {}, 1);
  const auto read_all = [&batches] {
    while (batches.next()) {
    }
  };
  CHECK_THROWS_WITH(read_all(),
                    Contains("another plot in another stand") && Contains("unique in the file"));
}
