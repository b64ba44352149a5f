// SPDX-License-Identifier: MIT
#include "study_arguments.hpp"

#include <utility>

namespace silvafit::cli {
namespace {

/// One criterion for all levels; likelihood-ratio tests are then not used.
void apply_criterion(const std::string& text, study::StudyOptions& options) {
  if (text == "level") return;
  const study::Criterion all = study::parse_criterion(text);
  options.criteria = {.base = all, .covariates = all, .random = all, .variance = all};
  options.needs_tests = false;
}

/// The settings of the file, except those given on the command line.
void apply_configuration(const CLI::App& command, StudyArguments& arguments) {
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  study::StudyConfiguration file =
      study::read_study_configuration(arguments.configuration, &catalogue);
  study::StudyConfiguration& given = arguments.settings;
  const auto keep = [&command](const char* option, auto& value, auto& of_file) {
    if (command.count(option) > 0) of_file = std::move(value);
  };
  keep("--species", given.study.species, file.study.species);
  keep("--responses", given.study.responses, file.study.responses);
  keep("--covariates", given.study.covariates, file.study.covariates);
  keep("--group", given.study.group, file.study.group);
  keep("--period", given.study.period, file.study.period);
  keep("--minimum-trees", given.study.minimum_trees, file.study.minimum_trees);
  keep("--columns", given.reading.columns, file.reading.columns);
  keep("--trust-units", given.reading.trust_units, file.reading.trust_units);
  keep("--missing", given.reading.missing, file.reading.missing);
  keep("--fill-down", given.reading.fill_down, file.reading.fill_down);
  keep("--dead", given.reading.dead, file.reading.dead);
  keep("--alive-codes", given.reading.alive_codes, file.reading.alive_codes);
  keep("--dead-codes", given.reading.dead_codes, file.reading.dead_codes);
  keep("--cut-codes", given.reading.cut_codes, file.reading.cut_codes);
  keep("--case-sensitive", given.reading.case_sensitive, file.reading.case_sensitive);
  // A window of the command line replaces a circle of the file, and vice versa.
  if (command.count("--window") > 0 || command.count("--circle") > 0) {
    file.units.window = given.units.window;
    file.units.circle = given.units.circle;
  }
  keep("--edge", given.units.edge, file.units.edge);
  keep("--buffer", given.units.buffer_m, file.units.buffer_m);
  keep("--per", given.units.per, file.units.per);
  keep("--neighbors", given.units.neighbors, file.units.neighbors);
  keep("--alpha", given.units.alpha, file.units.alpha);
  keep("--dominance", given.units.dominance, file.units.dominance);
  keep("--crowding", given.units.crowding, file.units.crowding);
  keep("--further", given.units.further, file.units.further);
  keep("--competition-radius", given.units.competition_radius_m, file.units.competition_radius_m);
  keep("--open-grown", given.units.open_grown, file.units.open_grown);
  // A table of plots of the command line replaces that of the file.
  if (arguments.plots.file.empty()) arguments.plots.file = file.sampling.plots_file;
  keep("--plots-columns", given.sampling.plots_columns, file.sampling.plots_columns);
  keep("--circles", given.sampling.circles, file.sampling.circles);
  keep("--angle-count", given.sampling.angle_count, file.sampling.angle_count);
  keep("--smallest-dbh", given.sampling.smallest_dbh_cm, file.sampling.smallest_dbh_cm);
  keep("--expansion", given.sampling.expansion, file.sampling.expansion);
  keep("--expansion-area", given.sampling.expansion_area, file.sampling.expansion_area);
  keep("--subplots", given.sampling.subplots, file.sampling.subplots);
  keep("--subplot", given.sampling.subplot, file.sampling.subplot);
  keep("--slope-correction", given.sampling.slope_correction, file.sampling.slope_correction);
  given = std::move(file);
}

}  // namespace

void apply_settings(const CLI::App& command, StudyArguments& arguments) {
  if (!arguments.configuration.empty()) apply_configuration(command, arguments);
  arguments.settings.sampling.plots_file = arguments.plots.file;
  apply_criterion(arguments.criterion, arguments.settings.study);
}

}  // namespace silvafit::cli
