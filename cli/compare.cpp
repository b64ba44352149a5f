// SPDX-License-Identifier: MIT
// `silvafit compare`: fits beside each other, by information criteria and likelihood-ratio tests.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "command.hpp"
#include "library_named.hpp"
#include "output_files.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/comparison.hpp"
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
};

/// "heights.json", with the role or the number of the fit where the file has several.
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
  for (const std::string& file : files) result.libraries.push_back(library_named(file));
  for (std::size_t f = 0; f < files.size(); ++f) {
    const study::ModelLibrary& library = result.libraries[f];
    for (std::size_t i = 0; i < library.models.size(); ++i) {
      const study::LibraryModel& model = library.models[i];
      result.names[&model.fit] = name_of(files[f], library, i);
      subject_of(model, result.subjects).fits.push_back(&model.fit);
    }
  }
  std::erase_if(result.subjects, [](const Subject& subject) { return subject.fits.size() < 2; });
  if (result.subjects.empty()) {
    throw UsageError("no response has two fits to compare");
  }
  return result;
}

ordered_json json_of(const fit::ComparedFit& one, const NamedFits& named) {
  const fit::FittedModel& fit = *one.fit;
  return {{"name", named.names.at(&fit)},
          {"model", text_or_null(fit.model)},
          {"method", fit::method_text(fit.method)},
          {"k", fit.parameter_count > 0 ? ordered_json(fit.parameter_count) : ordered_json()},
          {"log_likelihood", number_or_null(fit.log_likelihood)},
          {"aic", number_or_null(fit.aic())},
          {"aicc", number_or_null(fit.aicc())},
          {"bic", number_or_null(fit.bic())},
          {"bic_groups", number_or_null(fit.bic_groups())},
          {"aic_difference", number_or_null(one.aic_difference)},
          {"akaike_weight", number_or_null(one.akaike_weight)}};
}

ordered_json json_of(const fit::ComparedPair& pair,
                     const fit::Comparison& comparison,
                     const NamedFits& named) {
  ordered_json result{{"larger", named.names.at(comparison.fits[pair.larger].fit)},
                      {"smaller", named.names.at(comparison.fits[pair.smaller].fit)}};
  if (!pair.test) {
    result["why_not"] = pair.reason;
    return result;
  }
  const fit::NestedTest& test = *pair.test;
  result["statistic"] = number_or_null(test.statistic);
  result["df"] = test.degrees_of_freedom;
  result["p_chi_squared"] = number_or_null(test.p_chi_squared);
  result["p"] = number_or_null(test.p);
  result["reference"] = test.reference.text();
  if (!test.note.empty()) result["note"] = test.note;
  return result;
}

ordered_json json_of(const Subject& subject, const NamedFits& named) {
  const fit::Comparison comparison = fit::compare(subject.fits);
  ordered_json result{{"species", text_or_null(subject.species)},
                      {"response", subject.response},
                      {"why_not_comparable", text_or_null(comparison.reason)},
                      {"fits", ordered_json::array()},
                      {"tests", ordered_json::array()},
                      {"not_converged", ordered_json::array()}};
  for (const fit::ComparedFit& one : comparison.fits) result["fits"].push_back(json_of(one, named));
  for (const fit::ComparedPair& pair : comparison.pairs) {
    result["tests"].push_back(json_of(pair, comparison, named));
  }
  for (const fit::FittedModel* const fit : comparison.failed) {
    result["not_converged"].push_back(named.names.at(fit));
  }
  return result;
}

std::string shown(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

void print_fits(const fit::Comparison& comparison, const NamedFits& named, std::size_t width) {
  print_text("{:<{}} {:<7} {:>3} {:>14} {:>13} {:>13} {:>13} {:>13} {:>10} {:>7}\n",
             "fit",
             width,
             "method",
             "k",
             "log-likelihood",
             "AIC",
             "AICc",
             "BIC",
             "BIC by groups",
             "difference",
             "weight");
  for (const fit::ComparedFit& one : comparison.fits) {
    const fit::FittedModel& fit = *one.fit;
    print_text("{:<{}} {:<7} {:>3} {:>14.4f} {:>13} {:>13} {:>13} {:>13} {:>10} {:>7}\n",
               named.names.at(&fit),
               width,
               fit::method_text(fit.method),
               fit.parameter_count > 0 ? fmt::to_string(fit.parameter_count) : "-",
               fit.log_likelihood,
               shown(fit.aic(), "{:.4f}"),
               shown(fit.aicc(), "{:.4f}"),
               shown(fit.bic(), "{:.4f}"),
               shown(fit.bic_groups(), "{:.4f}"),
               shown(one.aic_difference, "{:.4f}"),
               shown(one.akaike_weight, "{:.4f}"));
  }
}

void print_pair(const fit::ComparedPair& pair,
                const fit::Comparison& comparison,
                const NamedFits& named) {
  const std::string& larger = named.names.at(comparison.fits[pair.larger].fit);
  const std::string& smaller = named.names.at(comparison.fits[pair.smaller].fit);
  if (!pair.test) {
    print_text("{} against {}: not tested, {}\n", larger, smaller, pair.reason);
    return;
  }
  const fit::NestedTest& test = *pair.test;
  print_text("{} against {}: likelihood ratio {:.4f}, df {}, p {:.3g} by chi-squared",
             larger,
             smaller,
             test.statistic,
             test.degrees_of_freedom,
             test.p_chi_squared);
  if (test.reference.weights.size() > 1) {
    print_text(", {:.3g} by {}", test.p, test.reference.text());
  }
  print_text("{}{}\n", test.note.empty() ? "" : "; ", test.note);
}

void print_table(const Subject& subject, const NamedFits& named) {
  const fit::Comparison comparison = fit::compare(subject.fits);
  std::size_t width = 3;
  for (const fit::FittedModel* const fit : subject.fits) {
    width = std::max(width, named.names.at(fit).size());
  }
  print_text("{}{}{}\n", subject.species, subject.species.empty() ? "" : " ", subject.response);
  print_fits(comparison, named, width);
  if (!comparison.reason.empty()) {
    print_text("the criteria cannot be compared: {}\n", comparison.reason);
  }
  for (const fit::FittedModel* const fit : comparison.failed) {
    print_text("not converged: {}\n", named.names.at(fit));
  }
  print_text("\n");
  for (const fit::ComparedPair& pair : comparison.pairs) print_pair(pair, comparison, named);
}

/// The libraries side by side as a page.
void write_page(const CompareArguments& arguments,
                const std::vector<study::ModelLibrary>& libraries) {
  std::vector<std::string> names;
  for (const std::string& file : arguments.files) {
    names.push_back(std::filesystem::path(file).filename().string());
  }
  // Two files of one name are told apart by their folders.
  if (std::set<std::string>(names.begin(), names.end()).size() < names.size()) {
    names = arguments.files;
  }
  study::write_comparison_page(libraries, names, bundled_page("report.html"), arguments.html);
}

void run(const CompareArguments& arguments) {
  refuse_same_files(all_of("FIT.json", arguments.files), {{"--html", arguments.html}});
  const NamedFits named = read_fits(arguments.files);
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
