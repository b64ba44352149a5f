// SPDX-License-Identifier: MIT
// `silvafit models`: the catalogue of base models, and of the builders' presets.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/tree/builder.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

using study::BaseModel;

struct ModelsOptions {
  CommonOptions common{};
  std::vector<std::string> ids{};
  std::string response{};
  bool builders = false;
  bool equations = false;
};

void print_table(const std::vector<const BaseModel*>& models) {
  std::size_t name_width = 4;
  for (const BaseModel* model : models) name_width = std::max(name_width, model->name.size());
  print_text("{:<5} {:<{}}  {:<8}  {}\n", "id", "name", name_width, "response", "formula");
  for (const BaseModel* model : models) {
    print_text("{:<5} {:<{}}  {:<8}  {}\n",
               model->id,
               model->name,
               name_width,
               model->response,
               model->formula);
  }
}

/// Its limits, and the conditions for a plausible curve in a study.
void print_sense(const BaseModel& model) {
  print_text("at DBH 0\n  {}\n", model.at_zero.text());
  if (model.at_infinity) print_text("for large DBH\n  {}\n", model.at_infinity->text());
  if (model.sensible.empty()) return;
  print_text("plausible where (top_dbh: 1.2 times the largest DBH)\n");
  for (const study::SensibleCondition& each : model.sensible) {
    print_text("  {}; else {}\n", each.condition.text(), each.otherwise);
  }
}

void print_entry(const BaseModel& model) {
  print_text("{} {}\n  {}\n", model.id, model.name, model.formula);
  print_text("parameters\n");
  for (const study::BaseParameter& parameter : model.parameters) {
    print_text("  {:<4} {} [{}], {}; starts at {}\n",
               parameter.name,
               parameter.meaning,
               parameter.unit,
               word_of(parameter.sign),
               parameter.start.text());
  }
  print_sense(model);
  print_text("domain\n");
  for (const data::Expression& condition : model.domain) print_text("  {}\n", condition.text());
  for (const study::Equivalence& equivalence : model.equals) {
    std::vector<std::string> where;
    for (const auto& [name, value] : equivalence.where) {
      where.push_back(fmt::format("{} = {}", name, value.text()));
    }
    print_text("the same as {}{}{}\n",
               equivalence.model,
               where.empty() ? "" : " where ",
               fmt::join(where, ", "));
  }
  if (!model.notes.empty()) print_text("notes\n  {}\n", model.notes);
  print_text("source\n");
  for (const std::string& source : model.source) print_text("  {}\n", source);
}

/// The complete entries of the files, with keys that the program does not read.
void print_json(const std::vector<const BaseModel*>& models) {
  nlohmann::ordered_json result;
  result["schema"] = "silvafit-models/1";
  result["models"] = nlohmann::ordered_json::array();
  for (const BaseModel* model : models) {
    result["models"].push_back(nlohmann::ordered_json::parse(read_file(model->file)));
  }
  print_json_value(result);
}

std::vector<const BaseModel*> chosen(const study::Catalogue& catalogue,
                                     const ModelsOptions& options) {
  std::vector<const BaseModel*> result;
  for (const std::string& id : options.ids) result.push_back(&catalogue.find(id));
  if (!result.empty()) return result;
  for (const BaseModel& model : catalogue.models()) {
    if (options.response.empty() || model.response == options.response) result.push_back(&model);
  }
  return result;
}

// ---- Presets of trees -------------------------------------------------------------------------

/// The names that choose a preset; "*" is printed as a phrase for all other names.
std::string species_text(std::vector<std::string> names) {
  std::replace(names.begin(), names.end(), std::string("*"), std::string("any other"));
  return fmt::format("{}", fmt::join(names, ", "));
}

void print_builders(const tree::BuilderCatalogue& catalogue) {
  for (const tree::BuilderKind kind : all_values<tree::BuilderKind>()) {
    print_text("{}\n", word_of(kind));
    for (const tree::Builder* builder : catalogue.of(kind)) {
      const tree::PresetHead& preset = builder->preset();
      print_text("  {:<24} {}\n", preset.name, preset.title);
      const std::vector<std::string> species = catalogue.species_of(*builder);
      if (!species.empty()) print_text("  {:<24}   {}\n", "", species_text(species));
    }
  }
}

void print_builders_json(const tree::BuilderCatalogue& catalogue) {
  nlohmann::ordered_json result;
  result["schema"] = "silvafit-builders/1";
  result["builders"] = nlohmann::ordered_json::array();
  for (const tree::BuilderKind kind : all_values<tree::BuilderKind>()) {
    nlohmann::ordered_json presets = nlohmann::ordered_json::array();
    for (const tree::Builder* builder : catalogue.of(kind)) {
      const tree::PresetHead& preset = builder->preset();
      presets.push_back({{"name", preset.name},
                         {"title", preset.title},
                         {"species", catalogue.species_of(*builder)}});
    }
    result["builders"].push_back({{"builder", word_of(kind)}, {"presets", std::move(presets)}});
  }
  print_json_value(result);
}

void show_builders(const ModelsOptions& options) {
  const auto catalogue = tree::BuilderCatalogue::load(data_directory() / "models");
  if (options.common.json) {
    print_builders_json(catalogue);
  } else {
    print_builders(catalogue);
  }
}

// ---- Equations of volume, biomass and carbon --------------------------------------------------

std::string domain_text(const study::TreeEquation& equation) {
  std::vector<std::string> parts;
  for (const study::EquationRange& range : equation.domain) {
    parts.push_back(fmt::format("{} {} to {}", range.column, range.low, range.high));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void print_equation(const study::TreeEquation& equation) {
  print_text("{}\n  {} [{}]\n  {}\n",
             equation.id,
             equation.title.empty() ? equation.quantity : equation.title,
             equation.unit,
             equation.formula);
  if (!equation.species.empty()) {
    print_text("  species: {}\n", fmt::format("{}", fmt::join(equation.species, ", ")));
  }
  if (!equation.region.empty()) print_text("  region: {}\n", equation.region);
  if (!equation.domain.empty()) print_text("  domain: {}\n", domain_text(equation));
  for (const std::string& source : equation.source) print_text("  source: {}\n", source);
}

nlohmann::ordered_json equation_json(const study::TreeEquation& equation) {
  nlohmann::ordered_json domain = nlohmann::ordered_json::object();
  for (const study::EquationRange& range : equation.domain) {
    domain[range.column] = {range.low, range.high};
  }
  return {{"id", equation.id},
          {"title", equation.title},
          {"quantity", equation.quantity},
          {"unit", equation.unit},
          {"formula", equation.formula},
          {"value", equation.value.text()},
          {"species", equation.species},
          {"region", equation.region},
          {"domain", std::move(domain)},
          {"source", equation.source}};
}

void show_equations(const ModelsOptions& options) {
  const auto equations = study::TreeEquations::load(data_directory() / "models");
  std::vector<const study::TreeEquation*> chosen;
  for (const std::string& id : options.ids) chosen.push_back(&equations.find(id));
  if (options.ids.empty()) {
    for (const study::TreeEquation& equation : equations.all()) chosen.push_back(&equation);
  }
  if (!options.common.json) {
    for (const study::TreeEquation* const equation : chosen) print_equation(*equation);
    return;
  }
  nlohmann::ordered_json result{{"schema", "silvafit-equations/1"},
                                {"equations", nlohmann::ordered_json::array()}};
  for (const study::TreeEquation* const equation : chosen) {
    result["equations"].push_back(equation_json(*equation));
  }
  print_json_value(result);
}

void run(const ModelsOptions& options) {
  if (options.equations) {
    show_equations(options);
    return;
  }
  if (options.builders) {
    show_builders(options);
    return;
  }
  const study::Catalogue catalogue = study::Catalogue::load(data_directory() / "models");
  const std::vector<const BaseModel*> models = chosen(catalogue, options);
  if (options.common.json) {
    print_json(models);
  } else if (options.ids.empty()) {
    print_table(models);
  } else {
    for (const BaseModel* model : models) print_entry(*model);
  }
}

}  // namespace

void add_models_command(CLI::App& program) {
  auto options = std::make_shared<ModelsOptions>();
  CLI::App* command = program.add_subcommand(
      "models",
      "Show the catalogue of base models, equations of volume and biomass, or tree builders");
  add_common_options(*command, options->common);
  command->add_option("id", options->ids, "Entries to show in full, such as M4");
  command->add_option("--response", options->response, "Only models for h, hcb or cw")
      ->check(CLI::IsMember({"h", "hcb", "cw"}))
      ->excludes("id");
  command->add_flag("--builders", options->builders, "Tree builders and their presets, for `grow`")
      ->excludes("id")
      ->excludes("--response");
  command
      ->add_flag("--equations",
                 options->equations,
                 "Equations of volume, biomass and carbon, for `stand` and `predict`")
      ->excludes("--builders")
      ->excludes("--response");
  add_example(*command, "silvafit models --response cw");
  command->callback([options] { run(*options); });
}

}  // namespace silvafit::cli
