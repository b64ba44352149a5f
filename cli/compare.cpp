// SPDX-License-Identifier: MIT
// `silvafit compare`: compares fits by information criteria and likelihood-ratio tests.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "command.hpp"
#include "output_files.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/comparison.hpp"
#include "silvafit/fit/inference_json.hpp"
#include "silvafit/fit/summary.hpp"
#include "silvafit/study/comparison_page.hpp"
#include "silvafit/study/model_library.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct CompareArguments {
  CommonOptions common{};
  std::vector<std::string> files{};
  std::string html{};
};

/// The fits of one species and response, and their names in tables.
struct Subject {
  std::string species{};
  std::string response{};
  std::vector<const fit::FittedModel*> fits{};
};

struct NamedFits {
  std::vector<study::ModelLibrary> libraries{};
  std::map<const fit::FittedModel*, std::string> names{};
  std::vector<Subject> subjects{};
  std::vector<std::string> notes{};  ///< fits without another for the same response
};

/// "heights.json", with the role or number of the fit if the file has several fits.
std::string name_of(const std::string& file, const study::ModelLibrary& library, std::size_t i) {
  if (library.models.size() == 1) return file;
  const study::LibraryModel& model = library.models[i];
  const std::string what = !model.role.empty()        ? model.role
                           : !model.fit.model.empty() ? model.fit.model
                                                      : std::to_string(i + 1);
  return fmt::format("{}:{}", file, what);
}

Subject& subject_of(const study::LibraryModel& model, std::vector<Subject>& subjects) {
  const auto found = std::ranges::find_if(subjects, [&](const Subject& subject) {
    return subject.species == model.species && subject.response == model.response;
  });
  if (found != subjects.end()) return *found;
  return subjects.emplace_back(Subject{.species = model.species, .response = model.response});
}

NamedFits read_fits(const std::vector<std::string>& files) {
  NamedFits result;
  for (const std::string& file : files)
    result.libraries.push_back(study::find_library(file, data_directory() / "models"));
  for (std::size_t f = 0; f < files.size(); ++f) {
    const study::ModelLibrary& library = result.libraries[f];
    for (std::size_t i = 0; i < library.models.size(); ++i) {
      const study::LibraryModel& model = library.models[i];
      result.names[&model.fit] = name_of(files[f], library, i);
      subject_of(model, result.subjects).fits.push_back(&model.fit);
    }
  }
  for (const Subject& subject : result.subjects) {
    if (subject.fits.size() > 1) continue;
    result.notes.push_back(fmt::format("{} is not compared: it is the only fit for {}{}{}",
                                       result.names.at(subject.fits.front()),
                                       subject.response,
                                       subject.species.empty() ? "" : " of ",
                                       subject.species));
  }
  std::erase_if(result.subjects, [](const Subject& subject) { return subject.fits.size() < 2; });
  if (result.subjects.empty()) {
    throw UsageError("no response has two fits to compare");
  }
  return result;
}

ordered_json json_of(const Subject& subject, const NamedFits& named) {
  ordered_json result{{"species", text_or_null(subject.species)}, {"response", subject.response}};
  result.update(fit::json_of(fit::compare(subject.fits), named.names));
  return result;
}

void print_table(const Subject& subject, const NamedFits& named) {
  print_text("{}{}{}\n{}",
             subject.species,
             subject.species.empty() ? "" : " ",
             subject.response,
             with_options(fit::summary(fit::compare(subject.fits), named.names)));
}

/// A page that compares the libraries.
void write_page(const CompareArguments& arguments,
                const std::vector<study::ModelLibrary>& libraries) {
  std::vector<std::string> names;
  for (const std::string& file : arguments.files) {
    names.push_back(std::filesystem::path(file).filename().string());
  }
  // The folder distinguishes two files of the same name.
  if (std::set<std::string>(names.begin(), names.end()).size() < names.size()) {
    names = arguments.files;
  }
  study::write_comparison_page(libraries, names, bundled_page("report.html"), arguments.html);
}

void run(const CompareArguments& arguments) {
  refuse_same_files(all_of("FIT.json", arguments.files), {{"--html", arguments.html}});
  const NamedFits named = read_fits(arguments.files);
  for (const std::string& note : named.notes) say(arguments.common, "note: " + note);
  if (!arguments.html.empty()) write_page(arguments, named.libraries);
  if (arguments.common.json) {
    ordered_json result{{"schema", "silvafit-compare/1"}, {"comparisons", ordered_json::array()}};
    for (const Subject& subject : named.subjects) {
      result["comparisons"].push_back(json_of(subject, named));
    }
    print_json_value(result);
    return;
  }
  bool is_first = true;
  for (const Subject& subject : named.subjects) {
    if (!is_first) print_text("\n");
    is_first = false;
    print_table(subject, named);
  }
}

}  // namespace

void add_compare_command(CLI::App& program) {
  const auto arguments = std::make_shared<CompareArguments>();
  CLI::App& command = *program.add_subcommand(
      "compare", "Compare fits by information criteria and likelihood-ratio tests");
  command
      .add_option(
          "fits", arguments->files, "Output of fit --json, model libraries, or published libraries")
      ->type_name("FIT.json")
      ->required();
  command
      .add_option("--html", arguments->html, "HTML page to write, with the libraries side by side")
      ->type_name("FILE.html");
  add_common_options(command, arguments->common);
  add_example(command, "silvafit compare one-effect.json two-effects.json");
  command.callback([arguments] { run(*arguments); });
}

}  // namespace silvafit::cli
