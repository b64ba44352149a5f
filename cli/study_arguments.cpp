// SPDX-License-Identifier: MIT
#include "study_arguments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <utility>

#include "silvafit/base/paths.hpp"

namespace silvafit::cli {
namespace {

/// One criterion for all levels, which then decides alone.
void apply_criterion(const std::string& text, study::StudyOptions& options) {
  if (text == "level") return;
  const study::Criterion all = study::parse_criterion(text);
  options.criteria = {.base = all, .covariates = all, .random = all, .variance = all};
  options.needs_tests = false;
}

/// What a file says of structural units, but for what the command line says itself.
void apply_units(const CLI::App& command,
                 const study::StudyConfiguration& file,
                 UnitArguments& units) {
  const auto take = [&command](const char* option, const auto& said, auto& value) {
    if (said && command.count(option) == 0) value = *said;
  };
  // A window of the command line replaces a circle of the file, and the other way round.
  const bool has_area = command.count("--window") > 0 || command.count("--circle") > 0;
  if (!has_area) {
    take("--window", file.window, units.window);
    take("--circle", file.circle, units.circle);
  }
  take("--edge", file.edge, units.edge);
  take("--buffer", file.buffer_m, units.buffer_m);
  take("--per", file.units.per, units.per);
  take("--neighbors", file.units.neighbors, units.neighbors);
  take("--alpha", file.units.alpha, units.alpha);
  take("--dominance", file.units.dominance, units.dominance);
  take("--crowding", file.units.crowding, units.crowding);
  take("--further", file.further, units.further);
  take("--competition-radius", file.units.competition_radius_m, units.competition_radius_m);
  take("--open-grown", file.units.open_grown, units.open_grown);
}

void apply_configuration(const CLI::App& command, StudyArguments& arguments) {
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  const study::StudyConfiguration file =
      study::read_study_configuration(arguments.configuration, &catalogue);
  const auto is_given = [&](const char* option) { return command.count(option) > 0; };
  study::StudyOptions options = file.study;
  if (is_given("--species")) options.species = arguments.study.species;
  if (is_given("--responses")) options.responses = arguments.study.responses;
  if (is_given("--covariates")) options.covariates = arguments.study.covariates;
  if (is_given("--group")) options.group = arguments.study.group;
  if (is_given("--minimum-trees")) options.minimum_trees = arguments.study.minimum_trees;
  arguments.study = std::move(options);
  InventoryArguments& inventory = arguments.inventory;
  if (!is_given("--columns")) inventory.columns = file.columns;
  if (!is_given("--trust-units")) inventory.trust_units = file.trust_units.value_or(false);
  SheetArguments& sheet = inventory.sheet;
  if (!is_given("--missing")) sheet.missing = file.missing;
  if (!is_given("--fill-down")) sheet.fill_down = file.fill_down;
  if (!is_given("--dead")) sheet.dead = file.dead.value_or(sheet.dead);
  if (!is_given("--case-sensitive")) sheet.case_sensitive = file.case_sensitive.value_or(false);
  apply_units(command, file, arguments.units);
}

/// A file as seen from a folder; what is named from the root stays so.
std::string seen_from(const std::filesystem::path& folder, const std::string& file) {
  if (file.empty() || std::filesystem::path(file).is_absolute()) return file;
  const std::filesystem::path from = followed(folder.empty() ? "." : folder);
  return followed(file).lexically_proximate(from).string();
}

}  // namespace

void apply_settings(const CLI::App& command, StudyArguments& arguments) {
  if (!arguments.configuration.empty()) apply_configuration(command, arguments);
  apply_criterion(arguments.criterion, arguments.study);
}

study::StudyConfiguration settings_of(const StudyArguments& arguments,
                                      const std::filesystem::path& folder) {
  const UnitArguments& units = arguments.units;
  study::StudyConfiguration settings{.study = arguments.study,
                                     .window = seen_from(folder, units.window),
                                     .edge = units.edge,
                                     .buffer_m = units.buffer_m,
                                     .trust_units = arguments.inventory.trust_units,
                                     .missing = arguments.inventory.sheet.missing,
                                     .fill_down = arguments.inventory.sheet.fill_down,
                                     .dead = arguments.inventory.sheet.dead,
                                     .case_sensitive = arguments.inventory.sheet.case_sensitive,
                                     .circle = units.circle,
                                     .further = units.further,
                                     .units = {.per = units.per,
                                               .neighbors = units.neighbors,
                                               .alpha = units.alpha,
                                               .dominance = units.dominance,
                                               .crowding = units.crowding,
                                               .competition_radius_m = units.competition_radius_m,
                                               .open_grown = units.open_grown}};
  const std::string columns = fmt::format("{}", fmt::join(arguments.inventory.columns, ","));
  for (const stand::ColumnMapping& mapping : stand::parse_column_mappings(columns)) {
    settings.columns.push_back(mapping.name + "=" + mapping.source);
  }
  return settings;
}

}  // namespace silvafit::cli
