// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cmath>

#include "report/report_json.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/stand/stand_report.hpp"

using namespace silvafit;

namespace {

fit::FittedModel curve_with(const std::string& formula, const std::vector<double>& values) {
  data::Table table;
  table.set("dbh", std::vector<double>{10.0, 20.0, 30.0});
  table.set("h", std::vector<double>{9.0, 15.0, 18.0});
  table.set("age", std::vector<double>{20.0, 40.0, 60.0});
  fit::FittedModel fit(fit::specify_model(formula, {}, table));
  fit.coefficient_names = fit.specification.coefficient_names();
  fit.estimate =
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  return fit;
}

}  // namespace

TEST_CASE("a curve is a formula of a spreadsheet with its coefficients") {
  const auto formula = [](const std::string& text, const std::vector<double>& values) {
    return study::spreadsheet_formula(curve_with(text, values), "A2");
  };
  CHECK(formula("h ~ a + b*log(dbh)", {2.0, 5.25}) == "=2+5.25*LN(A2)");
  // A spreadsheet computes -x^2 as (-x)^2, and 0-x^2 as it is meant.
  CHECK(formula("h ~ a*exp(-dbh^b)", {30.0, 1.5}).find("EXP(0-") != std::string::npos);
  CHECK(formula("h ~ a + b*age", {1.0, 2.0}).empty());
  CHECK(formula("h ~ a + b*dbh", {1.0, std::nan("")}).empty());
}

TEST_CASE("without areas the stand table has sizes and numbers of trees, and nothing per hectare") {
  study::StudyRecord record;
  stand::Inventory& trees = record.inventory.inventory;
  for (const char* plot : {"A", "A", "B"}) trees.plot.append(plot);
  for (const char* tree : {"1", "2", "1"}) trees.tree.append(tree);
  for (const char* species : {"fir", "oak", "fir"}) trees.species.append(species);
  trees.dbh_cm = {10.0, 20.0, 30.0};
  trees.h_m = {8.0, 12.0, data::kMissing};
  record.stand =
      stand::stand_report(trees, {.by = {"species"}, .without_areas = true, .without_units = true});
  const auto stand = *study::district_object(record);
  const auto& all = stand["tables"][0];
  REQUIRE(all["columns"].size() == 4);
  CHECK(all["columns"][2]["title"] == "dg (cm)");
  CHECK(all["rows"][0][1] == 3);
  // The root of (10^2 + 20^2 + 30^2)/3.
  CHECK(all["rows"][0][2].get<double>() == Approx(21.602).epsilon(1e-4));
  CHECK(all["rows"][0][3] == 10.0);
  CHECK(all["caption"].get<std::string>().find("area of plots is unknown") != std::string::npos);
  CHECK(stand["tables"][1]["rows"].size() == 4);
  CHECK(stand["diameters"].front()["trees"] == 1);
  CHECK(stand["diameters"].front()["stems_per_ha"].is_null());
}
