// SPDX-License-Identifier: MIT
// `silvafit library`: the content of a model library, and the scenes of its structural classes.
#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "output_files.hpp"
#include "setting_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/scenes.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct ShowArguments {
  CommonOptions common{};
  std::string library{};
};

std::string coefficients_text(const fit::FittedModel& fit) {
  std::string text;
  for (std::size_t j = 0; j < fit.coefficient_names.size(); ++j) {
    text += fmt::format("{}{} {:.6g}",
                        j == 0 ? "" : ", ",
                        fit.coefficient_names[j],
                        fit.estimate[static_cast<Eigen::Index>(j)]);
  }
  return text;
}

void print_models(const study::ModelLibrary& library) {
  for (const study::LibraryModel& model : library.models) {
    print_text("{:<8} {:<4} {:<10} {}\n",
               model.species,
               model.response,
               model.role,
               model.fit.specification.formula.text);
    print_text("    {}\n", coefficients_text(model.fit));
  }
}

void show(const ShowArguments& arguments) {
  if (arguments.library.empty()) {
    const std::vector<std::string> names = study::published_libraries(data_directory() / "models");
    if (arguments.common.json) {
      print_json_value({{"published", names}});
    } else {
      for (const std::string& name : names) print_text("{}\n", name);
    }
    return;
  }
  const study::ModelLibrary library =
      study::find_library(arguments.library, data_directory() / "models");
  if (arguments.common.json) {
    print_text("{}", study::to_json(library));
  } else {
    print_models(library);
  }
}

struct SceneArguments {
  CommonOptions common{};
  std::string library{};
  std::string out{};
  study::SceneOptions options{};
};

void print_summary(const SceneArguments& arguments, const study::Scenes& scenes) {
  ordered_json species = ordered_json::array();
  for (const study::SpeciesScenes& of : scenes.species) {
    species.push_back({{"species", of.species},
                       {"dbh", of.dbh_cm},
                       {"indices", of.indices},
                       {"scenes", of.scenes}});
  }
  print_json_value({{"schema", "silvafit-scenes/1"},
                    {"silvafit", version()},
                    {"out", arguments.out},
                    {"species", std::move(species)},
                    {"trees", scenes.trees.rows()}});
}

void make_scenes(const SceneArguments& arguments) {
  refuse_same_files({{"LIBRARY", arguments.library}}, {{"--out", arguments.out}});
  if (arguments.common.json && arguments.out.empty()) {
    throw UsageError("--json prints a summary; name the file of the trees with --out");
  }
  const study::Scenes scenes = study::scenes_of(
      study::find_library(arguments.library, data_directory() / "models"), arguments.options);
  if (arguments.out.empty()) {
    data::write_csv_table(scenes.trees, std::cout);
    finish_standard_output();
  } else {
    data::write_csv_table(scenes.trees, arguments.out);
  }
  for (const study::SpeciesScenes& of : scenes.species) {
    say(arguments.common,
        fmt::format("{}: {} of a tree of {} cm, {}",
                    of.species.empty() ? "all" : of.species,
                    counted(of.scenes, "scene", "scenes"),
                    of.dbh_cm,
                    of.indices.empty() ? "whose models depend on no index"
                                       : fmt::format("by {}", fmt::join(of.indices, ", "))));
  }
  if (arguments.common.json) print_summary(arguments, scenes);
}

void add_show_command(CLI::App& library) {
  const auto arguments = std::make_shared<ShowArguments>();
  CLI::App& command = *library.add_subcommand(
      "show", "List the models of a library; without a library, list the published ones");
  command.add_option("library", arguments->library, "library.json, or a published library")
      ->type_name("LIBRARY");
  add_common_options(command, arguments->common);
  add_example(command, "silvafit library show shanxia-2023");
  command.callback([arguments] { show(*arguments); });
}

void add_scenes_command(CLI::App& library) {
  const auto arguments = std::make_shared<SceneArguments>();
  CLI::App& command = *library.add_subcommand("scenes",
                                              "Predict a reference tree of every structural class, "
                                              "with the neighbors that define the class");
  command.add_option("library", arguments->library, "library.json, or a published library")
      ->type_name("LIBRARY")
      ->required();
  command.add_option("--out", arguments->out, "CSV file to write (default: standard output)")
      ->type_name("FILE.csv");
  each_setting(arguments->options, SettingOptions(command, "Scenes"));
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit library scenes shanxia-2023 --species SM --out scenes.csv\n"
              "  silvafit grow scenes.csv --scene scenes.glb");
  command.callback([arguments] { make_scenes(*arguments); });
}

}  // namespace

void add_library_command(CLI::App& program) {
  CLI::App& command =
      *program.add_subcommand("library", "Show a model library and make scenes from it");
  command.require_subcommand(1);
  add_example(command, "silvafit library show");
  add_show_command(command);
  add_scenes_command(command);
}

}  // namespace silvafit::cli
