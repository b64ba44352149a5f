// SPDX-License-Identifier: MIT
// Designs of simulations as JSON.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/study/simulate.hpp"
#include "simulation/covariance_root.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;
/// Sets a number that may be missing.
void set_if_there(const JsonReader& json, const char* key, double& target) {
  if (const auto value = json.find(key)) target = value->number();
}
void set_not_negative(const JsonReader& json, const char* key, double& target) {
  if (const auto value = json.find(key)) target = value->not_negative();
}
void set_positive(const JsonReader& json, const char* key, double& target) {
  if (const auto value = json.find(key)) target = value->positive();
}

PlotDesign read_plot(const JsonReader& json) {
  json.allow_only({"id", "x0", "y0", "x1", "y1"});
  PlotDesign plot{.id = json.at("id").text(),
                  .x0 = json.at("x0").number(),
                  .y0 = json.at("y0").number(),
                  .x1 = json.at("x1").number(),
                  .y1 = json.at("y1").number()};
  if (!(plot.x0 < plot.x1)) json.fail("x0 must be below x1");
  if (!(plot.y0 < plot.y1)) json.fail("y0 must be below y1");
  return plot;
}

std::vector<PlotDesign> grid_of_plots(const JsonReader& json) {
  json.allow_only({"columns", "rows", "width", "height", "gap"});
  const std::size_t columns = json.at("columns").count();
  const std::size_t rows = json.at("rows").count();
  constexpr double kMostPlots = 1e6;
  if (static_cast<double>(columns) * static_cast<double>(rows) > kMostPlots) {
    json.fail(fmt::format("{} columns and {} rows are more than a million plots", columns, rows));
  }
  const double width = json.at("width").positive();
  const double height = json.at("height").positive();
  double gap = 0.0;
  set_not_negative(json, "gap", gap);
  std::vector<PlotDesign> plots;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const double x0 = static_cast<double>(column) * (width + gap);
      const double y0 = static_cast<double>(row) * (height + gap);
      plots.push_back({.id = fmt::format("{}", plots.size() + 1),
                       .x0 = x0,
                       .y0 = y0,
                       .x1 = x0 + width,
                       .y1 = y0 + height});
    }
  }
  return plots;
}

/// Two plots that overlap, if there are such plots. Sweeps from west to east: of plots that do not
/// overlap, those at one x are sorted from south to north, so that each is compared with two others
/// most.
std::optional<std::pair<std::size_t, std::size_t>> overlapping(
    const std::vector<PlotDesign>& plots) {
  struct Side {
    double x = 0.0;
    bool is_west = false;  // plots end before others begin at the same x
    std::size_t plot = 0;
  };
  std::vector<Side> sides;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    sides.push_back({plots[i].x0, true, i});
    sides.push_back({plots[i].x1, false, i});
  }
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return std::tie(a.x, a.is_west, a.plot) < std::tie(b.x, b.is_west, b.plot);
  });
  std::map<double, std::size_t> from_south;
  for (const Side& side : sides) {
    const PlotDesign& plot = plots[side.plot];
    if (!side.is_west) {
      from_south.erase(plot.y0);
      continue;
    }
    const auto north = from_south.lower_bound(plot.y0);
    if (north != from_south.end() && north->first < plot.y1) return {{north->second, side.plot}};
    if (north != from_south.begin()) {
      const std::size_t south = std::prev(north)->second;
      if (plots[south].y1 > plot.y0) return {{south, side.plot}};
    }
    from_south.emplace(plot.y0, side.plot);
  }
  return std::nullopt;
}

void check_plots_apart(const std::vector<PlotDesign>& plots, const JsonReader& json) {
  std::set<std::string_view> ids;
  for (const PlotDesign& plot : plots) {
    if (!ids.insert(plot.id).second) json.fail(fmt::format("two plots have the id {}", plot.id));
  }
  const auto found = overlapping(plots);
  if (!found) return;
  const auto [first, second] = std::minmax(found->first, found->second);
  json.fail(fmt::format("the plots {} and {} overlap", plots[first].id, plots[second].id));
}

std::vector<PlotDesign> read_plots(const JsonReader& json) {
  if (json.is_object()) return grid_of_plots(json.at("grid"));
  std::vector<PlotDesign> plots;
  for (const JsonReader& item : json.items()) plots.push_back(read_plot(item));
  if (plots.empty()) json.fail("at least one plot is needed");
  check_plots_apart(plots, json);
  return plots;
}

StemDesign read_stems(const JsonReader& json) {
  json.allow_only({"minimum_distance", "patch_length"});
  StemDesign stems;
  set_not_negative(json, "minimum_distance", stems.minimum_distance_m);
  set_positive(json, "patch_length", stems.patch_length_m);
  return stems;
}

TerrainDesign read_terrain(const JsonReader& json) {
  json.allow_only({"base", "slope_east", "slope_north", "hill_sd", "hill_length", "plot_sd"});
  TerrainDesign terrain;
  set_if_there(json, "base", terrain.base_m);
  set_if_there(json, "slope_east", terrain.slope_east);
  set_if_there(json, "slope_north", terrain.slope_north);
  set_not_negative(json, "hill_sd", terrain.hill_sd_m);
  set_positive(json, "hill_length", terrain.hill_length_m);
  set_not_negative(json, "plot_sd", terrain.plot_sd_m);
  return terrain;
}

DbhDesign read_dbh(const JsonReader& json) {
  json.allow_only({"minimum", "mean", "sd", "plot_log_sd"});
  DbhDesign dbh;
  set_positive(json, "minimum", dbh.minimum_cm);
  dbh.mean_cm = json.at("mean").number();
  dbh.sd_cm = json.at("sd").positive();
  set_not_negative(json, "plot_log_sd", dbh.plot_log_sd);
  if (!(dbh.mean_cm > dbh.minimum_cm)) {
    json.at("mean").fail(fmt::format("must be above the minimum of {} cm", dbh.minimum_cm));
  }
  const double above = dbh.mean_cm - dbh.minimum_cm;
  const double factor_variance = std::expm1(dbh.plot_log_sd * dbh.plot_log_sd);
  if (!(above * std::sqrt(factor_variance) < dbh.sd_cm)) {
    json.at("plot_log_sd").fail("the spread between plots is larger than sd");
  }
  return dbh;
}

/// A table without rows with the columns that the formula of a mean may use. Covariates are used in
/// sub-models only, so that a parameter may be called c although there is a column C.
data::Table columns_for(const std::string& response) {
  data::Table table(0);
  table.set("dbh", std::vector<double>{});
  if (response == "hcb") table.set("h", std::vector<double>{});
  return table;
}

const std::set<std::string>& known_covariates() {
  static const std::set<std::string> names{"C", "M", "U", "W", "dbh", "z"};
  return names;
}

fit::ParameterModel read_parameter(const JsonReader& json) {
  const std::set<std::string>& known = known_covariates();
  try {
    fit::ParameterModel parameter = fit::parse_parameter_model(json.text());
    for (const fit::Covariate& covariate : parameter.covariates) {
      for (const std::string& name : covariate.value.variables()) {
        if (known.contains(name)) continue;
        json.fail(
            fmt::format("unknown covariate '{}'; available: {}", name, fmt::join(known, ", ")));
      }
    }
    return parameter;
  } catch (const UsageError& error) {
    json.fail(error.what());
  }
}

fit::ModelSpecification read_formula(const JsonReader& json, const std::string& response) {
  try {
    fit::ModelSpecification model = fit::specify_model(json.text(), {}, columns_for(response));
    if (model.formula.left != response) json.fail(fmt::format("must begin with {} ~", response));
    for (const fit::ParameterModel& parameter : model.parameters) {
      if (known_covariates().contains(parameter.name)) {
        json.fail(
            fmt::format("'{}' can be used only in a sub-model of a parameter, such as b ~ 1 + {}",
                        parameter.name,
                        parameter.name));
      }
    }
    return model;
  } catch (const UsageError& error) {
    json.fail(error.what());
  }
}

fit::ModelSpecification read_model(const JsonReader& json, const std::string& response) {
  fit::ModelSpecification model = read_formula(json.at("formula"), response);
  const auto sub_models = json.find("parameters");
  if (!sub_models) return model;
  for (const JsonReader& item : sub_models->items()) {
    fit::ParameterModel parameter = read_parameter(item);
    const auto target =
        std::find_if(model.parameters.begin(), model.parameters.end(), [&](const auto& known) {
          return known.name == parameter.name;
        });
    if (target == model.parameters.end()) {
      item.fail(fmt::format("unknown parameter '{}' of {}", parameter.name, model.formula.text));
    }
    *target = std::move(parameter);
  }
  return model;
}

Eigen::VectorXd read_fixed(const JsonReader& json, const std::vector<std::string>& names) {
  const auto values = json.numbers_by_name();
  Eigen::VectorXd fixed(static_cast<Eigen::Index>(names.size()));
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = values.find(names[i]);
    if (found == values.end() || values.size() != names.size()) {
      json.fail(fmt::format("must give {}", fmt::join(names, ", ")));
    }
    fixed[static_cast<Eigen::Index>(i)] = found->second;
  }
  return fixed;
}

Eigen::MatrixXd read_matrix(const JsonReader& json, std::size_t size) {
  const std::vector<JsonReader> rows = json.items();
  Eigen::MatrixXd matrix(size, size);
  if (rows.size() != size) json.fail(fmt::format("must have {} rows", size));
  for (std::size_t i = 0; i < size; ++i) {
    const std::vector<double> row = rows[i].numbers();
    if (row.size() != size) rows[i].fail("must have " + counted(size, "number", "numbers"));
    for (std::size_t j = 0; j < size; ++j) {
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = row[j];
    }
  }
  if (matrix != matrix.transpose()) json.fail("must be symmetric");
  return matrix;
}

Eigen::MatrixXd read_covariance(const JsonReader& json, std::size_t size) {
  if (const auto covariance = json.find("covariance")) return read_matrix(*covariance, size);
  const JsonReader variances = json.at("variance");
  const std::vector<double> values = variances.numbers();
  if (values.size() != size) variances.fail("must have " + counted(size, "number", "numbers"));
  Eigen::VectorXd sd(size);
  for (std::size_t i = 0; i < size; ++i) {
    if (values[i] < 0.0) variances.fail("must not be negative");
    sd[static_cast<Eigen::Index>(i)] = std::sqrt(values[i]);
  }
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(sd.size(), sd.size());
  if (const auto given = json.find("correlation")) {
    correlation = read_matrix(*given, size);
    if ((correlation.diagonal().array() != 1.0).any()) given->fail("must have 1 on the diagonal");
  }
  return sd.asDiagonal() * correlation * sd.asDiagonal();
}

void read_random(const JsonReader& json, ResponseDesign& response) {
  json.allow_only({"effects", "variance", "correlation", "covariance"});
  const JsonReader effects = json.at("effects");
  const std::vector<std::string> names = effects.texts();
  const std::vector<std::string> known = response.model.coefficient_names();
  if (names.empty()) effects.fail("at least one random effect is needed");
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(known.begin(), known.end(), names[i]) == known.end()) {
      effects.fail(
          fmt::format("unknown coefficient '{}'; available: {}", names[i], fmt::join(known, ", ")));
    }
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
        names.begin() + static_cast<std::ptrdiff_t>(i)) {
      effects.fail(fmt::format("'{}' is given twice", names[i]));
    }
  }
  response.model.random = {{.coefficients = names, .group = "plot"}};
  response.random_covariance = read_covariance(json, names.size());
  if (!covariance_root(response.random_covariance)) {
    json.fail("the covariance matrix of the random effects is not positive semidefinite");
  }
}

void read_variance(const JsonReader& json, ResponseDesign& response) {
  json.allow_only({"function", "delta", "constant"});
  const JsonReader function = json.at("function");
  try {
    response.model.variance = fit::parse_variance_function(function.text());
  } catch (const UsageError& error) {
    function.fail(error.what());
  }
  for (const fit::VarianceFactor& factor : response.model.variance.factors) {
    const bool is_simple = response.model.variance.factors.size() == 1 && factor.stratum.empty() &&
                           !factor.delta && !factor.constant;
    if (!is_simple) function.fail("must be one function without strata and fixed parameters");
    if (!factor.column.empty() && factor.column != "dbh") {
      function.fail("can depend on the fitted value or on dbh");
    }
  }
  const int parameters = response.model.variance.parameter_count();
  if (parameters >= 1) response.delta = json.at("delta").number();
  if (parameters >= 2) response.constant = json.at("constant").not_negative();
  if (parameters < 1 && json.has("delta"))
    json.at("delta").fail("this function has no such parameter");
  if (parameters < 2 && json.has("constant"))
    json.at("constant").fail("this function has no such parameter");
}

ResponseDesign read_response(const JsonReader& json, const std::string& name) {
  json.allow_only(
      {"formula", "parameters", "fixed", "random", "variance", "sigma", "residual_rms"});
  ResponseDesign response{.model = read_model(json, name)};
  response.fixed = read_fixed(json.at("fixed"), response.model.coefficient_names());
  if (const auto random = json.find("random")) read_random(*random, response);
  if (const auto variance = json.find("variance")) read_variance(*variance, response);
  if (const auto sigma = json.find("sigma")) response.sigma = sigma->not_negative();
  if (const auto rms = json.find("residual_rms")) response.residual_rms = rms->not_negative();
  if (response.sigma.has_value() == response.residual_rms.has_value()) {
    json.fail("needs either sigma or residual_rms");
  }
  return response;
}

SpeciesDesign read_species(const JsonReader& json) {
  json.allow_only({"code", "name", "density", "patchiness", "dbh", "h", "hcb", "cw"});
  SpeciesDesign species{.h = read_response(json.at("h"), "h"),
                        .hcb = read_response(json.at("hcb"), "hcb"),
                        .cw = read_response(json.at("cw"), "cw")};
  species.code = json.at("code").text();
  if (const auto name = json.find("name")) species.name = name->text();
  species.density_per_ha = json.at("density").positive();
  set_not_negative(json, "patchiness", species.patchiness);
  species.dbh = read_dbh(json.at("dbh"));
  return species;
}

/// Checked before memory for an unreasonable number of trees is requested.
void check_number_of_trees(const SimulationDesign& design, const JsonReader& json) {
  constexpr double kMostTrees = 5e7;
  double hectares = 0.0;
  for (const PlotDesign& plot : design.plots) hectares += plot.area_m2() / 1e4;
  double trees = 0.0;
  for (const SpeciesDesign& species : design.species) trees += species.density_per_ha * hectares;
  if (trees <= kMostTrees) return;
  json.fail(
      fmt::format("the densities give {:.3g} trees on {:.4g} ha, more than {:.0g}; density is in "
                  "stems per hectare",
                  trees,
                  hectares,
                  kMostTrees));
}

SimulationDesign read(const JsonReader& json) {
  json.allow_only({"schema",
                   "name",
                   "notes",
                   "plots",
                   "stems",
                   "terrain",
                   "neighbors",
                   "crown_asymmetry",
                   "species"});
  json.at("schema").one_of({"silvafit-design/1"});
  SimulationDesign design;
  if (const auto name = json.find("name")) design.name = name->text();
  design.plots = read_plots(json.at("plots"));
  if (const auto stems = json.find("stems")) design.stems = read_stems(*stems);
  if (const auto terrain = json.find("terrain")) design.terrain = read_terrain(*terrain);
  if (const auto neighbors = json.find("neighbors")) {
    neighbors->allow_only({"count", "within"});
    design.neighbors = neighbors->at("count").count();
    const bool of_plot = neighbors->at("within").one_of({"stand", "plot"}) == 1;
    design.scope = of_plot ? stand::SearchScope::kPlot : stand::SearchScope::kStand;
  }
  if (const auto asymmetry = json.find("crown_asymmetry")) {
    design.crown_asymmetry = asymmetry->number_between(0.0, 0.3);
  }
  const JsonReader species = json.at("species");
  std::set<std::string> codes;
  for (const JsonReader& item : species.items()) {
    design.species.push_back(read_species(item));
    if (!codes.insert(design.species.back().code).second) {
      item.at("code").fail("another species has this code");
    }
  }
  if (design.species.empty()) species.fail("at least one species is needed");
  check_number_of_trees(design, species);
  return design;
}

}  // namespace

SimulationDesign read_design(const std::filesystem::path& path) {
  return read(JsonReader::open(path));
}

SimulationDesign parse_design(std::string_view text, const std::string& file) {
  return read(JsonReader::parse(text, file));
}

}  // namespace silvafit::study
