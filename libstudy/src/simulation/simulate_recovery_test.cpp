// SPDX-License-Identifier: MIT
// Simulate, fit, recover: mixed models fitted to the example find the design that it was drawn
// from.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "reference.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/simulate.hpp"

using namespace silvafit;

namespace {

/// The species' trees with the indices of the file.
data::Table trees_of(const std::string& species) {
  const stand::Inventory inventory =
      stand::read_inventory(test::source_file("examples/fir-mixed/inventory.csv")).inventory;
  const stand::StructuralUnits units = stand::structural_units(
      inventory, {.edge = stand::EdgeCorrection::kNone, .scope = stand::SearchScope::kStand});
  data::Table table = stand::to_table(inventory);
  table.set("W", units.W);
  table.set("M", units.M);
  table.set("U", units.U);
  table.set("C", units.C);
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (inventory.species[row] == species) rows.push_back(row);
  }
  return table.select(rows);
}

fit::MixedEffectsFit fitted(const study::ResponseDesign& design, const data::Table& table) {
  const fit::NonlinearModel model(design.model, table);
  return fit::fit_lindstrom_bates(model, design.fixed);
}

void check_recovery(const study::ResponseDesign& design, const data::Table& table) {
  const fit::MixedEffectsFit fit = fitted(design, table);
  INFO(design.model.formula.text << ": " << fit.convergence.verdict());
  REQUIRE(fit.coefficient_names == design.model.coefficient_names());
  const Eigen::VectorXd errors = fit.standard_errors();
  for (Eigen::Index i = 0; i < design.fixed.size(); ++i) {
    INFO(fit.coefficient_names[static_cast<std::size_t>(i)]
         << ": " << fit.estimate[i] << " +- " << errors[i] << ", truth " << design.fixed[i]);
    // Ten plots give the standard errors about ten degrees of freedom, where |t| > 4 has p = 1/400.
    CHECK(std::abs(fit.estimate[i] - design.fixed[i]) < 4.0 * errors[i]);
  }
}

double estimate_of(const fit::MixedEffectsFit& fit, const std::string& name) {
  const auto found = std::find(fit.coefficient_names.begin(), fit.coefficient_names.end(), name);
  REQUIRE(found != fit.coefficient_names.end());
  return fit.estimate[found - fit.coefficient_names.begin()];
}

study::SimulationDesign example() {
  return study::read_design(test::source_file("examples/fir-mixed/design.json"));
}

bool is_main(const study::SpeciesDesign& species) {
  return species.code == "SM" || species.code == "BHN" || species.code == "MH";
}

}  // namespace

TEST_CASE("mixed models recover the heights and crown bases of the example's design") {
  const study::SimulationDesign design = example();
  for (const study::SpeciesDesign& species : design.species) {
    if (!is_main(species)) continue;
    INFO(species.code);
    const data::Table table = trees_of(species.code);
    check_recovery(species.h, table);
    check_recovery(species.hcb, table);
  }
}

TEST_CASE("a regression of crown width on C is biased, because C depends on the crown") {
  // A crown that is wide by chance overlaps more neighbors: its residual and C are correlated, and
  // least squares or likelihood of one tree at a time attribute that to C.
  const study::SimulationDesign design = example();
  for (const study::SpeciesDesign& species : design.species) {
    if (!is_main(species)) continue;
    INFO(species.code);
    const fit::MixedEffectsFit fit = fitted(species.cw, trees_of(species.code));
    const std::string coefficient = species.code == "MH" ? "a:C" : "c:C";
    const std::vector<std::string> names = species.cw.model.coefficient_names();
    const auto index = std::find(names.begin(), names.end(), coefficient) - names.begin();
    CHECK(estimate_of(fit, coefficient) >
          species.cw.fixed[index] + 2.0 * fit.standard_errors()[index]);
  }
}
