// SPDX-License-Identifier: MIT
// `silvafit models`: the catalogue of base models.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/study/catalogue.hpp"

namespace silvafit::cli {
namespace {

using study::BaseModel;

struct ModelsOptions {
  CommonOptions common{};
  std::vector<std::string> ids{};
  std::string response{};
};

const char* word_of(study::Sign sign) {
  switch (sign) {
    case study::Sign::kPositive:
      return "positive";
    case study::Sign::kNegative:
      return "negative";
    case study::Sign::kAny:
      return "any sign";
  }
  return "";
}

void print_table(const std::vector<const BaseModel*>& models) {
  std::size_t name_width = 4;
  for (const BaseModel* model : models) name_width = std::max(name_width, model->name.size());
  fmt::print("{:<5} {:<{}}  {:<8}  {}\n", "id", "name", name_width, "response", "formula");
  for (const BaseModel* model : models) {
    fmt::print("{:<5} {:<{}}  {:<8}  {}\n",
               model->id,
               model->name,
               name_width,
               model->response,
               model->formula);
  }
}

void print_entry(const BaseModel& model) {
  fmt::print("{} {}\n  {}\n", model.id, model.name, model.formula);
  fmt::print("parameters\n");
  for (const study::BaseParameter& parameter : model.parameters) {
    fmt::print("  {:<4} {} [{}], {}; starts at {}\n",
               parameter.name,
               parameter.meaning,
               parameter.unit,
               word_of(parameter.sign),
               parameter.start.text());
  }
  fmt::print("domain\n");
  for (const data::Expression& condition : model.domain) fmt::print("  {}\n", condition.text());
  for (const study::Equivalence& equivalence : model.equals) {
    std::vector<std::string> where;
    for (const auto& [name, value] : equivalence.where) {
      where.push_back(fmt::format("{} = {}", name, value.text()));
    }
    fmt::print("the same as {}{}{}\n",
               equivalence.model,
               where.empty() ? "" : " where ",
               fmt::join(where, ", "));
  }
  if (!model.notes.empty()) fmt::print("notes\n  {}\n", model.notes);
  fmt::print("source\n");
  for (const std::string& source : model.source) fmt::print("  {}\n", source);
}

/// The entries as their files have them, which is more than the program reads.
void print_json(const std::vector<const BaseModel*>& models) {
  nlohmann::ordered_json result;
  result["schema"] = "silvafit-models/1";
  result["models"] = nlohmann::ordered_json::array();
  for (const BaseModel* model : models) {
    result["models"].push_back(nlohmann::ordered_json::parse(read_file(model->file)));
  }
  fmt::print("{}\n", result.dump(2));
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

void run(const ModelsOptions& options) {
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
  CLI::App* command = program.add_subcommand("models", "Show the catalogue of base models");
  add_common_options(*command, options->common);
  command->add_option("id", options->ids, "Entries to show whole, such as M4");
  command->add_option("--response", options->response, "Only models of h, hcb or cw")
      ->check(CLI::IsMember({"h", "hcb", "cw"}));
  add_example(*command, "silvafit models --response cw");
  command->callback([options] { run(*options); });
}

}  // namespace silvafit::cli
