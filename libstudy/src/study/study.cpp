// SPDX-License-Identifier: MIT
#include "silvafit/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/name_list.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "study/study_work.hpp"

namespace silvafit::study {
namespace {

void check_options(const Catalogue& catalogue, const StudyOptions& options) {
  std::set<std::string> known;
  for (const BaseModel& model : catalogue.models()) known.insert(model.response);
  for (const std::string& response : options.responses) {
    if (known.contains(response) || options.candidates.contains(response)) continue;
    throw UsageError(
        fmt::format("the catalogue has no models for '{}'; it has models for {}. Give candidates "
                    "of your own in a study.json",
                    response,
                    fmt::join(known, ", ")));
  }
  for (const std::string& covariate : options.covariates) {
    if (std::ranges::find(options.responses, covariate) == options.responses.end()) continue;
    throw UsageError(fmt::format("'{}' is a response and cannot be its own covariate; remove it, "
                                 "or study the other responses separately",
                                 covariate),
                     {.column = "`covariates`"});
  }
  if (options.responses.empty()) throw UsageError("no response was given");
  if (options.covariate_parameters < 1 || options.covariate_parameters > 2) {
    throw UsageError("covariates can be on one parameter or on two");
  }
  if (!(options.significance > 0.0 && options.significance < 1.0)) {
    throw UsageError("a level of significance must be between 0 and 1");
  }
  if (!(options.equally_good >= 0.0)) {
    throw UsageError("equally_good must be 0 or more");
  }
  for (const std::string& text : options.variance_functions) fit::parse_variance_function(text);
}

std::vector<std::string> without_repeats(const std::vector<std::string>& names) {
  std::vector<std::string> result;
  for (const std::string& name : names) {
    if (std::ranges::find(result, name) == result.end()) result.push_back(name);
  }
  return result;
}

/// Notes on requested covariates that are not numeric, with one note for all structural indices.
void note_covariates(const data::Table& table, Study& study) {
  const std::vector<std::string>& covariates = study.options.covariates;
  if (covariates.empty()) {
    study.notes.emplace_back("No covariates were given: level 2 was skipped.");
    return;
  }
  const bool has_any = std::ranges::any_of(
      covariates, [&](const std::string& name) { return has_numbers(table, name); });
  if (!has_any && covariates == StudyOptions{}.covariates) {
    study.notes.emplace_back(
        "The inventory has no tree positions or no core trees, so there are no structural units: "
        "level 2 was skipped.");
    return;
  }
  const bool has_units = table.has("W") || table.has("M");
  for (const std::string& name : covariates) {
    if (has_numbers(table, name)) continue;
    if (table.has(name)) {
      study.notes.push_back(fmt::format("{} holds text and is not used as a covariate.", name));
    } else if (has_units || covariates != StudyOptions{}.covariates) {
      study.notes.push_back(
          is_structure_name(name)
              ? fmt::format("{} needs {}, which the inventory does not have; it is not used as a "
                            "covariate.",
                            name,
                            is_plot_value_name(name) ? "the areas of plots" : "positions of trees")
              : fmt::format("The inventory has no column {}; it is not used as a covariate.",
                            name));
    }
  }
}

void note_what_is_left_out(const data::Table& table, Study& study) {
  note_covariates(table, study);
  for (const std::string& response : study.options.responses) {
    if (!has_numbers(table, response)) {
      study.notes.push_back(
          table.has(response)
              ? fmt::format("{} holds text; its models were skipped.", response)
              : fmt::format("The inventory has no column {}; its models were skipped.", response));
    }
  }
}

/// Species and responses with too few trees for models.
class SmallParts {
 public:
  void add(const Work& work) {
    const std::string& species = work.result.species;
    const std::string counts = tree_counts(work);
    if (parts_.empty() || parts_.back().species != species || parts_.back().counts != counts) {
      parts_.push_back({.species = species, .counts = counts});
    }
    parts_.back().responses.push_back(work.result.response);
    lacks_core_ = lacks_core_ || work.core < work.measured;
  }

  void note(std::size_t minimum_trees, Study& study) const {
    if (parts_.empty()) return;
    std::vector<std::string> texts;
    for (const Part& part : parts_) {
      texts.push_back(fmt::format(
          "{} {} ({})", data::in_list(part.species), fmt::join(part.responses, ", "), part.counts));
    }
    study.notes.push_back(fmt::format(
        "Too few trees for models (fewer than {}): {}.{}",
        minimum_trees,
        fmt::join(texts, "; "),
        lacks_core_ ? " Trees near the plot edge are not core trees and are not counted; edge "
                      "correction none counts them."
                    : ""));
  }

 private:
  struct Part {
    std::string species{};
    std::string counts{};
    std::vector<std::string> responses{};
  };
  std::vector<Part> parts_{};
  bool lacks_core_ = false;
};

}  // namespace

std::size_t Study::fit_count() const {
  std::size_t count = 0;
  for (const StageTime& stage : stages) count += stage.fits;
  return count;
}

std::string unit_of(const std::string& response) {
  return response == "h" || response == "hcb" || response == "cw" ? "m" : "";
}

Study run_study(const data::Table& table,
                const Catalogue& catalogue,
                const StudyOptions& options,
                const ProgressCallback& progress) {
  check_options(catalogue, options);
  Study study{.options = options};
  study.options.species = without_repeats(options.species);
  study.options.responses = without_repeats(options.responses);
  note_what_is_left_out(table, study);
  SmallParts small;
  std::vector<Work> works;
  for (const std::string& species : species_of(table, study.options)) {
    for (const std::string& response : study.options.responses) {
      Work work = prepared(table, catalogue, options, species, response);
      const std::size_t trees = work.result.rows.size();
      if (trees >= options.minimum_trees) {
        works.push_back(std::move(work));
      } else if (has_numbers(table, response)) {
        small.add(work);
      }
    }
  }
  small.note(options.minimum_trees, study);
  run_stages(works, study, progress);
  for (Work& work : works) {
    check_final_model(work.result, table, options.significance);
    study.results.push_back(std::move(work.result));
  }
  return study;
}

}  // namespace silvafit::study
