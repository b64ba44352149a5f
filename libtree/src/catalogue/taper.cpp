// SPDX-License-Identifier: MIT
#include "silvafit/tree/taper.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "catalogue/preset_head.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/expression.hpp"

namespace silvafit::tree {
namespace {

data::Expression equation_of(const data::JsonReader& entry) {
  data::Expression equation = entry.at("relative_diameter").expression();
  for (const auto& [name, value] : entry.at("coefficients").numbers_by_name()) {
    equation = equation.substitute(name, data::Expression::constant(value));
  }
  return equation;
}

}  // namespace

Taper Taper::load(const std::filesystem::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-taper/1");
  Taper taper;
  taper.name_ = entry.at("name").text();
  taper.source_ = entry.at("source").text();
  taper.butt_limit_ = entry.at("butt_limit").number_between(1.0, 10.0);
  try {
    const std::array<data::Expression, 1> outputs{equation_of(entry)};
    taper.program_ = data::Program(outputs,
                                   {{.name = "x", .is_scalar = false},
                                    {.name = "h", .is_scalar = true},
                                    {.name = "dbh", .is_scalar = true}});
  } catch (const UsageError& error) {
    entry.at("relative_diameter").fail(error.message());
  }
  taper.check_ends(entry.file());
  return taper;
}

void Taper::check_ends(const std::string& file) const {
  for (const double h_m : {2.0, 10.0, 40.0}) {
    const std::vector<double> ends = diameters_cm(std::array{kBreastHeight, h_m}, h_m, 25.0);
    if (ends[0] != 25.0 || ends[1] != 0.0) {
      throw InputError("must be exactly 1 at 1.3 m and 0 at the tip",
                       {.file = file, .column = "relative_diameter"});
    }
  }
}

std::vector<double> Taper::diameters_cm(std::span<const double> heights_m,
                                        double h_m,
                                        double dbh_cm) const {
  std::vector<double> diameters(heights_m.size());
  const std::array<const double*, 3> inputs{heights_m.data(), &h_m, &dbh_cm};
  const std::array<double*, 1> outputs{diameters.data()};
  data::Program::Workspace workspace;
  program_.evaluate(inputs, heights_m.size(), outputs, workspace);
  for (std::size_t i = 0; i < diameters.size(); ++i) {
    double& relative = diameters[i];
    if (heights_m[i] < kBreastHeight) {
      // The equation may overflow near the ground for a tree that has just reached 1.3 m.
      relative = std::isnan(relative) ? butt_limit_ : std::min(relative, butt_limit_);
    }
    if (!(relative >= 0.0 && std::isfinite(relative))) {
      throw NumericalError("the taper equation gives no valid diameter", {.model = name_});
    }
    relative *= dbh_cm;
  }
  return diameters;
}

std::vector<double> Taper::radii_m(std::span<const double> heights_m,
                                   double h_m,
                                   double dbh_cm) const {
  constexpr double kRadiusPerDiameter = 0.5 * 0.01;  // m per cm
  std::vector<double> radii = diameters_cm(heights_m, h_m, dbh_cm);
  for (double& radius : radii) radius *= kRadiusPerDiameter;
  return radii;
}

}  // namespace silvafit::tree
