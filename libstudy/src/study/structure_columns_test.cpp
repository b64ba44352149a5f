// SPDX-License-Identifier: MIT
#include "silvafit/study/structure_columns.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "silvafit/study/table_checks.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

using Names = std::vector<std::string>;

/// Two plots of five trees; in each a tree in the middle, and one tree without a position.
data::Table two_plots() {
  data::Table table;
  data::TextColumn plot;
  data::TextColumn species;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> dbh;
  std::vector<double> cw;
  for (const char* name : {"a", "b"}) {
    const std::vector<double> east{5, 0, 10, 10, 0};
    const std::vector<double> north{5, 0, 0, 10, 10};
    for (std::size_t i = 0; i < 5; ++i) {
      plot.append(name);
      species.append(i % 2 == 0 ? "SM" : "MH");
      x.push_back(east[i]);
      y.push_back(north[i]);
      dbh.push_back(10.0 + 2.0 * static_cast<double>(i));
      cw.push_back(3.0);
    }
  }
  plot.append("b");
  species.append("SM");
  x.push_back(data::kMissing);
  y.push_back(1.0);
  dbh.push_back(99.0);
  cw.push_back(9.0);
  table.set("plot", plot);
  table.set("species", species);
  table.set("x", x);
  table.set("y", y);
  table.set("dbh", dbh);
  table.set("cw", cw);
  return table;
}

}  // namespace

TEST_CASE("structure names in formulas are found if the table lacks them") {
  const data::Table table = two_plots();
  CHECK(structure_names_in({"h ~ 1.3 + a*(1 - exp(-b*dbh))", "b ~ 1 + C + BAL:U"}, table) ==
        Names{"C", "BAL", "U"});
  CHECK(structure_names_in({"species == \"M\" && core == 1", "core"}, table) == Names{"core"});
  CHECK(structure_names_in({"W2 + aW + T(dbh) + M.x"}, table).empty());
  data::Table with_c = table;
  with_c.set("C", std::vector<double>(table.rows(), 0.5));
  CHECK(structure_names_in({"C + M"}, with_c) == Names{"M"});
  // Without positions they are ordinary names.
  data::Table unplaced;
  unplaced.set("dbh", std::vector<double>{1.0});
  CHECK(structure_names_in({"M + C"}, unplaced).empty());
}

TEST_CASE("structure columns are computed by name from the table's trees") {
  data::Table table = two_plots();
  const Names notes = add_structure_columns(
      {"M", "U", "T", "BAL", "core", "stems_per_ha", "quadratic_mean_dbh"}, table);
  CHECK_THAT(notes.at(0), Contains("the convex hull of"));
  // The middle tree: neighbors SM MH SM MH at one distance, all thicker.
  CHECK(table.numbers("M")[0] == 0.5);
  CHECK(table.numbers("U")[0] == 1.0);
  const double differentiation = 1.0 - (10.0 / 12 + 10.0 / 14 + 10.0 / 16 + 10.0 / 18) / 4.0;
  CHECK(table.numbers("T")[5] == Approx(differentiation).epsilon(1e-14));
  // The hull has 100 m2; 12 cm and more are larger.
  const double larger_m2 = M_PI / 4e4 * (144 + 196 + 256 + 324);
  CHECK(table.numbers("BAL")[0] == Approx(larger_m2 / 0.01).epsilon(1e-13));
  CHECK(table.numbers("core")[0] == 1.0);
  CHECK(table.numbers("core")[1] == 0.0);
  CHECK(table.numbers("stems_per_ha")[3] == Approx(500.0).epsilon(1e-13));
  CHECK(table.numbers("quadratic_mean_dbh")[9] == Approx(std::sqrt(204.0)).epsilon(1e-13));
  for (const char* name : {"M", "BAL", "stems_per_ha"}) {
    CHECK(std::isnan(table.numbers(name)[10]));
  }
}

TEST_CASE("existing columns remain, and an index that cannot be computed is an error") {
  data::Table table = two_plots();
  table.set("M", std::vector<double>(table.rows(), 0.123));
  add_structure_columns({"M", "U"}, table);
  CHECK(table.numbers("M")[0] == 0.123);
  CHECK_THROWS_AS(add_structure_columns({"V"}, table), UsageError);
  CHECK_THROWS_WITH(add_structure_columns({"CCF"}, table), Contains("`open_grown`"));
  data::Table unplaced;
  unplaced.set("dbh", std::vector<double>{1.0});
  CHECK_THROWS_WITH(add_structure_columns({"W"}, unplaced), Contains("columns x, y and dbh"));
  CHECK_THROWS_WITH(require_numbers(table, {"C"}), Contains("`columns=C=C`"));
}

TEST_CASE("added columns may name an index that has to be computed") {
  data::Table table = two_plots();
  add_columns({{"U", "U"}, {"dominated", "U*100"}}, table);
  CHECK(table.numbers("U")[0] == 1.0);
  CHECK(table.numbers("dominated")[0] == 100.0);
}
