// SPDX-License-Identifier: MIT
// Equations of volume, biomass and carbon: the catalogue, units, the choice by species.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "reference.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/study/tree_equations.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

std::filesystem::path models_folder() { return test::source_file("models"); }

data::Table three_trees() {
  data::Table table(3);
  data::TextColumn species;
  for (const char* name : {"A", "B", "Picea abies"}) species.append(name);
  table.set("species", std::move(species));
  table.set("dbh", std::vector<double>{20, 30, 35});
  table.set("h", std::vector<double>{16, 22, NAN});
  return table;
}

std::string file_with(const std::string& entry) {
  const auto file = std::filesystem::temp_directory_path() / "silvafit_equations_test.json";
  std::ofstream(file)
      << R"({"schema": "silvafit-tree-equations/1", "source": ["test"], "equations": [)" << entry
      << "]}";
  return file.string();
}

EquationSettings using_equations(std::vector<std::string> equations) {
  return {.equations = std::move(equations), .models = models_folder()};
}

bool mentions(const std::vector<std::string>& notes, const std::string& text) {
  return std::ranges::any_of(
      notes, [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

}  // namespace

TEST_CASE(
    "Every equation of the catalogue has its reference points, a source and plausible values") {
  const TreeEquations equations = TreeEquations::load(models_folder());
  CHECK(equations.all().size() >= 14);
  for (const TreeEquation& equation : equations.all()) {
    INFO(equation.id);
    CHECK(!equation.source.empty());
    CHECK(!equation.reference_points.empty());
    for (const EquationPoint& point : equation.reference_points) {
      std::vector<std::string> names;
      std::vector<double> values;
      for (const auto& [name, value] : point.arguments) {
        names.push_back(name);
        values.push_back(value);
      }
      // Values are written with 16 digits; powers lose a few of them.
      CHECK(equation.value.value(names, values) == Approx(point.value).epsilon(1e-12));
    }
  }
}

TEST_CASE("Equations have the values of their publications") {
  // Laasasenaho 1982, spruce of 20 cm and 16 m, and Jenkins and others 2003, pine of 20 cm: from
  // the printed coefficients by Python, 0.24386 m3 and 116.595 kg.
  const TreeQuantities found = tree_quantities(
      three_trees(), using_equations({"laasasenaho-spruce", "jenkins-pine", "ipcc-carbon"}));
  REQUIRE(found.quantities.size() == 3);
  CHECK(found.quantities[0].unit == "m3");
  CHECK(found.quantities[0].values[0] == Approx(0.24386).epsilon(1e-5));
  CHECK(std::isnan(found.quantities[0].values[2]));
  CHECK(found.quantities[1].values[0] == Approx(116.595).epsilon(1e-5));
  CHECK(found.quantities[2].values[0] == Approx(0.47 * 116.595).epsilon(1e-5));
  CHECK(mentions(found.notes, "1 tree has no volume: a value that the equation needs is missing"));
}

TEST_CASE("Feet and inches are converted") {
  // Brackett 1977, bigleaf maple: 10 inches and 50 ft.
  EquationSettings settings = using_equations({"maple"});
  settings.files = {file_with(
      R"({"id": "maple", "quantity": "volume", "unit": "ft3", "units": {"dbh": "in", "h": "ft"},
          "formula": "10^a*dbh^b*h^c", "parameters": {"a": -2.770324, "b": 1.885813, "c": 1.119043},
          "domain": {"dbh": [1, 20]}})")};
  data::Table table(1);
  table.set("dbh", std::vector<double>{25.4});
  table.set("h", std::vector<double>{15.24});
  const double cubic_feet =
      std::pow(10.0, -2.770324) * std::pow(10.0, 1.885813) * std::pow(50.0, 1.119043);
  const TreeQuantities found = tree_quantities(table, settings);
  CHECK(found.quantities[0].values[0] == Approx(cubic_feet * 0.028316846592).epsilon(1e-13));
  CHECK(found.notes.empty());
  table.set("dbh", std::vector<double>{60.0});
  CHECK(mentions(tree_quantities(table, settings).notes,
                 "outside the domain of maple, dbh 2.54 to 50.8"));
}

TEST_CASE("A species uses its own equation, or the one that lists it") {
  const TreeQuantities own =
      tree_quantities(three_trees(), using_equations({"jenkins-oak", "b=jenkins-pine"}));
  CHECK(own.quantities[0].values[0] == Approx(std::exp(-2.0127 + 2.4342 * std::log(20))));
  CHECK(own.quantities[0].values[1] == Approx(std::exp(-2.5356 + 2.4349 * std::log(30))));
  data::Table table = three_trees();
  table.set("h", std::vector<double>{16, 22, 25});
  const TreeQuantities listed = tree_quantities(
      table, using_equations({"laasasenaho-pine", "laasasenaho-spruce", "A=laasasenaho-birch"}));
  CHECK(!std::isnan(listed.quantities[0].values[2]));
  CHECK(std::isnan(listed.quantities[0].values[1]));
  CHECK(mentions(listed.notes, "no equation lists the species"));
  const std::string used_for_others =
      "equation laasasenaho-pine is of Pinus sylvestris and is used for other species: ";
  CHECK(mentions(tree_quantities(table, using_equations({"laasasenaho-pine"})).notes,
                 used_for_others + "A, B"));
  CHECK_FALSE(mentions(
      tree_quantities(table, using_equations({"A=laasasenaho-pine", "b=laasasenaho-pine"})).notes,
      used_for_others));
  CHECK_THROWS_WITH(
      tree_quantities(three_trees(), using_equations({"jenkins-oak", "jenkins-pine"})),
      Contains("two equations of biomass for all species"));
}

TEST_CASE("The volume by the taper equation equals the sum of slices of the stem") {
  const TreeQuantities found = tree_quantities(three_trees(), using_equations({"taper"}));
  CHECK(found.quantities[0].name == "volume");
  // A plausible form factor: between a cone (1/3) and a cylinder.
  const double cylinder = M_PI / 4 * 0.2 * 0.2 * 16;
  CHECK(found.quantities[0].values[0] > cylinder / 3);
  CHECK(found.quantities[0].values[0] < 0.7 * cylinder);
  CHECK(std::isnan(found.quantities[0].values[2]));
}

TEST_CASE("Errors in equations give their place") {
  CHECK_THROWS_WITH(tree_quantities(three_trees(), using_equations({"jenkins-pin"})),
                    Contains("unknown equation 'jenkins-pin'") && Contains("jenkins-pine"));
  CHECK_THROWS_WITH(tree_quantities(three_trees(), using_equations({"chave-2014"})),
                    Contains("equation chave-2014 needs the column density"));
  const auto refused = [](const std::string& entry) {
    EquationSettings settings = using_equations({"x"});
    settings.files = {file_with(entry)};
    return settings;
  };
  CHECK_THROWS_WITH(
      tree_quantities(
          three_trees(),
          refused(R"({"id": "x", "quantity": "volume", "unit": "acre", "formula": "dbh"})")),
      Contains("equations[0].unit") && Contains("must be one of"));
  CHECK_THROWS_WITH(
      tree_quantities(
          three_trees(),
          refused(R"({"id": "x", "quantity": "volume", "unit": "m3", "formula": "3"})")),
      Contains("uses no column"));
}
