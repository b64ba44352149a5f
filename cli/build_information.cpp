// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "build_settings.hpp"
#include "command.hpp"
#include "program.hpp"
#include "revision.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/data/vector_instructions.hpp"
#include "silvafit/source/open_table.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

// Both are empty outside of a checkout, and without the libraries.
constexpr std::string_view kRevision = SILVAFIT_REVISION;
constexpr std::string_view kRenderer = SILVAFIT_RENDERER;

std::string build_as_text() {
  std::string text = fmt::format("silvafit {}\n", version());
  if (!kRevision.empty()) text += fmt::format("revision             {}\n", kRevision);
  text += fmt::format("compiler             {}\n", SILVAFIT_COMPILER);
  text += fmt::format("build type           {}\n", SILVAFIT_BUILD_TYPE);
  text += fmt::format(
      "render               {}\n",
      kRenderer.empty() ? std::string_view("no, built without Embree or libpng") : kRenderer);
  const std::string gdal = source::gdal_version();
  text += fmt::format("layers and databases {}\n",
                      gdal.empty() ? "no, built without GDAL" : "GDAL " + gdal);
  text += fmt::format("vector instructions  {}", data::vector_instructions());
  return text;
}

std::string build_as_json() {
  const nlohmann::ordered_json build = {
      {"schema", "silvafit-version/1"},
      {"silvafit", version()},
      {"revision", text_or_null(kRevision)},
      {"compiler", SILVAFIT_COMPILER},
      {"build_type", SILVAFIT_BUILD_TYPE},
      {"render", text_or_null(kRenderer)},
      {"gdal", text_or_null(source::gdal_version())},
      {"vector_instructions", data::vector_instructions()},
  };
  return json_text(build, 2);
}

}  // namespace

void add_version_options(CLI::App& program) {
  const auto json = std::make_shared<bool>(false);
  // Options are looked at in the order in which they are added: --json is known when --version is.
  CLI::Option* as_json = program.add_flag("--json", *json, "With --version: as JSON");
  CLI::Option* version_flag = program.add_flag_callback(
      "--version",
      [json] { throw CLI::CallForVersion(*json ? build_as_json() : build_as_text(), 0); },
      "Print the version and how the program was built, and exit");
  as_json->needs(version_flag);
}

void add_version_to_commands(CLI::App& program) {
  for (CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    const auto print = [command] {
      const CLI::Option* json = command->get_option_no_throw("--json");
      const bool as_json = json != nullptr && json->count() > 0;
      throw CLI::CallForVersion(as_json ? build_as_json() : build_as_text(), 0);
    };
    command->add_flag_callback("--version", print, "Print the version and exit");
    add_version_to_commands(*command);
  }
}

}  // namespace silvafit::cli
