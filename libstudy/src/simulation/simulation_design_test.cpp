// SPDX-License-Identifier: MIT
// Errors in a design are reported with their place.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "silvafit/base/error.hpp"
#include "silvafit/study/simulate.hpp"
#include "simulation/simulation_test_support.hpp"

using namespace silvafit;
using nlohmann::json;
using test::plain_design;
using test::stand_of;

TEST_CASE("designs that cannot be drawn are errors with the reason") {
  json design = plain_design();
  SECTION("no room") {
    design["stems"]["minimum_distance"] = 3;
    CHECK_THROWS_AS(stand_of(design), InputError);
    CHECK_THROWS_WITH(stand_of(design),
                      Catch::Contains("stems.minimum_distance") && Catch::Contains("no room"));
  }
  SECTION("too few trees for neighbors") {
    design["species"][0]["density"] = 12;
    design["neighbors"] = {{"count", 4}, {"within", "plot"}};
    CHECK_THROWS_WITH(
        stand_of(design),
        Catch::Contains("neighbors.count") && Catch::Contains("at least 4 neighbors"));
  }
  SECTION("a mean that is not finite") {
    design["species"][0]["h"]["formula"] = "h ~ a + b*log(5 - dbh)";
    CHECK_THROWS_AS(stand_of(design), DomainError);
  }
}

TEST_CASE("errors name the wrong key or value of a design") {
  struct Mistake {
    const char* pointer;
    const char* value;
    const char* message;
  };
  const Mistake mistakes[] = {
      {"/plots/grid/rows", "0", "plots.grid.rows: must be a whole number above 0, not 0"},
      {"/plots/grid/width", "-3", "plots.grid.width: must be above 0"},
      {"/plots",
       R"([{"id":"1","x0":0,"y0":0,"x1":9,"y1":9},{"id":"2","x0":5,"y0":0,"x1":9,"y1":9}])",
       "plots: the plots 1 and 2 overlap"},
      {"/plots", R"([{"id":"1","x0":9,"y0":0,"x1":0,"y1":9}])", "plots[0]: x0 must be below x1"},
      {"/schema", R"("silvafit-design/9")", "schema: must be one of silvafit-design/1"},
      {"/specie", "1", "unknown key \"specie\""},
      {"/species/0/code", "7", "species[0].code: must be a text, not 7"},
      {"/species/0/density", "\"many\"", "species[0].density: must be a number, not \"many\""},
      {"/species/0/density", "1e12", "species: the densities give 1e+12 trees on 1 ha"},
      {"/plots/grid/rows", "1000000000", "plots.grid: 2 columns and 1000000000 rows are more"},
      {"/species/0/dbh/mean", "4", "species[0].dbh.mean: must be above the minimum of 5 cm"},
      {"/species/0/dbh/plot_log_sd", "2", "species[0].dbh.plot_log_sd: the spread between plots"},
      {"/species/0/h/formula", R"("h ~ a + b*D")", "species[0].h"},
      {"/species/0/h/formula", R"("h ~ a + (b*dbh")", "species[0].h.formula: column"},
      {"/species/0/h/formula", R"("cw ~ a + b*dbh")", "species[0].h.formula: must begin with h ~"},
      {"/species/0/h/formula", R"("h ~ a + b*dbh + C")", "'C' can be used only in a sub-model"},
      {"/species/0/h/parameters",
       R"(["b ~ 1 + X"])",
       "species[0].h.parameters[0]: unknown covariate 'X'"},
      {"/species/0/h/parameters",
       R"(["q ~ 1 + C"])",
       "species[0].h.parameters[0]: unknown parameter 'q'"},
      {"/species/0/h/parameters", R"(["b ~ 1 + C"])", "species[0].h.fixed: must give a, b, b:C"},
      {"/species/0/h/random",
       R"({"effects": ["c"], "variance": [1]})",
       "species[0].h.random.effects: unknown coefficient 'c'"},
      {"/species/0/h/random",
       R"({"effects": ["a"], "variance": [1, 2]})",
       "species[0].h.random.variance: must have 1 number"},
      {"/species/0/h/random",
       R"({"effects": ["a", "b"], "variance": [1, 1], "correlation": [[1, 2], [2, 1]]})",
       "species[0].h.random: the covariance matrix of the random effects is not positive "
       "semidefinite"},
      {"/species/0/h/random",
       R"({"effects": ["a", "b"], "covariance": [[1, 0.5], [0.4, 1]]})",
       "species[0].h.random.covariance: must be symmetric"},
      {"/species/0/h/variance", R"({"function": "power"})", "the key \"delta\" is missing"},
      {"/species/0/h/variance",
       R"({"function": "none", "delta": 1})",
       "species[0].h.variance.delta: this function has no such parameter"},
      {"/species/0/h/variance", R"({"function": "cubic"})", "species[0].h.variance.function: "},
      {"/species/0/h/residual_rms", "1", "species[0].h: needs either sigma or residual_rms"},
      {"/neighbors",
       R"({"count": 4, "within": "forest"})",
       "neighbors.within: must be one of stand, plot"},
  };
  for (const Mistake& mistake : mistakes) {
    json design = plain_design();
    design[json::json_pointer(mistake.pointer)] = json::parse(mistake.value);
    INFO(mistake.pointer << " = " << mistake.value);
    CHECK_THROWS_AS(study::parse_design(design.dump(), "design.json"), InputError);
    CHECK_THROWS_WITH(study::parse_design(design.dump(), "design.json"),
                      Catch::StartsWith("design.json: ") && Catch::Contains(mistake.message));
  }
}
