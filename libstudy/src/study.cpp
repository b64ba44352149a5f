// SPDX-License-Identifier: MIT
#include "silvafit/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/fit/cross_validation.hpp"
#include "study_levels.hpp"

namespace silvafit::study {
namespace {

// A loss of R2 that changes which model to use for plots without measured trees.
constexpr double kNoticeablyWorse = 0.01;

/// A species and response in work: its trees and what it may use.
struct Work {
  ResponseStudy result{};
  data::Table table{};
  std::vector<BaseCandidate> candidates{};
  std::vector<std::string> covariates{};
};

/// One fit to be done, and where its result goes.
struct Task {
  Trial trial;
  std::size_t work = 0;
  std::size_t position = 0;
};

fit::FitResult failed_fit(const Trial& trial, const std::string& reason) {
  fit::FitResult result{.fit = {.model = trial.model, .specification = trial.specification}};
  if (trial.options.method) result.fit.method = *trial.options.method;
  result.fit.log_likelihood = std::numeric_limits<double>::quiet_NaN();
  result.fit.convergence.verdict = reason;
  return result;
}

fit::FitResult fit_trial(const Trial& trial, const data::Table& table) {
  try {
    fit::FitResult result = fit::fit_model(trial.specification, table, trial.options);
    result.fit.model = trial.model;
    return result;
  } catch (const Error& error) {
    return failed_fit(trial, error.message());
  }
}

/// Names in the order of the enumeration.
constexpr std::array<std::string_view, 4> kCriterionNames{"aic", "aicc", "bic", "cv"};

/// Trees of a plot left out from which level 3 predicts its others: as many as inventories often
/// measure.
constexpr std::size_t kCalibratingTrees = 5;

/// Standard error of a root mean square error, from the mean square errors of the folds.
double error_between_folds(const fit::CrossValidation& result) {
  const Eigen::VectorXd& predicted = result.measured > 0 ? result.calibrated : result.predicted;
  std::vector<double> sums(result.folds, 0.0);
  std::vector<double> counts(result.folds, 0.0);
  for (std::size_t i = 0; i < result.fold.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (std::isnan(predicted[at])) continue;
    sums[result.fold[i]] += std::pow(result.observed[at] - predicted[at], 2);
    counts[result.fold[i]] += 1.0;
  }
  std::vector<double> means;
  for (std::size_t k = 0; k < result.folds; ++k) {
    if (counts[k] > 0.0) means.push_back(sums[k] / counts[k]);
  }
  const Eigen::Map<const Eigen::ArrayXd> squares(means.data(),
                                                 static_cast<Eigen::Index>(means.size()));
  const auto n = static_cast<double>(means.size());
  if (means.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const double mean = squares.mean();
  const double error = std::sqrt((squares - mean).square().sum() / (n - 1.0) / n);
  return error / (2.0 * std::sqrt(mean));
}

std::optional<CrossValidated> cross_validated(const fit::FittedModel& fit,
                                              const data::Table& table,
                                              const std::string& group) {
  if (!fit.convergence.converged) return std::nullopt;
  const std::size_t measured = fit.has_random_effects() ? kCalibratingTrees : 0;
  try {
    // The tasks of a level are parallel already.
    const fit::CrossValidation result =
        fit::cross_validate(fit, table, {.group = group, .measured = measured, .threads = 1});
    return CrossValidated{
        .rmse = measured > 0 ? result.calibrated_statistics.rmse : result.statistics.rmse,
        .standard_error = error_between_folds(result),
        .folds = result.folds,
        .failed = result.failed.size(),
        .measured = measured};
  } catch (const Error&) {
    // One plot alone cannot be left out.
    return std::nullopt;
  }
}

/// Runs the fits of one level for all species and responses at once, so that no thread waits for a
/// single one.
class Level {
 public:
  Level(std::string name, std::vector<Work>& works, Criterion criterion, const std::string& group)
      : name_(std::move(name)), works_(works), criterion_(criterion), group_(group) {
    results_.resize(works.size());
    cross_validated_.resize(works.size());
  }

  void add(std::size_t work, std::vector<Trial> trials) {
    for (Trial& trial : trials) {
      tasks_.push_back(
          {.trial = std::move(trial), .work = work, .position = results_[work].size()});
      results_[work].emplace_back(
          fit::FitResult{.fit = {.specification = tasks_.back().trial.specification}});
      cross_validated_[work].emplace_back();
    }
  }

  void run(unsigned threads, const ProgressCallback& progress, std::vector<StageTime>& stages) {
    const auto start = std::chrono::steady_clock::now();
    std::atomic<std::size_t> done{0};
    parallel_for(tasks_.size(), threads, [&](std::size_t i) {
      const Task& task = tasks_[i];
      const data::Table& table = works_[task.work].table;
      fit::FitResult& result = results_[task.work][task.position];
      result = fit_trial(task.trial, table);
      if (criterion_ == Criterion::kCrossValidation) {
        cross_validated_[task.work][task.position] = cross_validated(result.fit, table, group_);
      }
      const std::size_t count = ++done;
      if (progress) progress(name_, count, tasks_.size());
    });
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    stages.push_back({.name = name_, .seconds = seconds.count(), .fits = tasks_.size()});
  }

  /// The fits of one work as candidates, in the order in which they were added.
  std::vector<Candidate> candidates(std::size_t work) const {
    std::vector<Candidate> list;
    for (const Task& task : tasks_) {
      if (task.work != work) continue;
      list.push_back({.terms = task.trial.terms,
                      .fit = results_[work][task.position].fit,
                      .cross_validated = cross_validated_[work][task.position]});
    }
    return list;
  }

  const fit::FitResult& result(std::size_t work, std::size_t position) const {
    return results_[work][position];
  }

 private:
  std::string name_;
  std::vector<Work>& works_;
  Criterion criterion_;
  std::string group_;
  std::vector<Task> tasks_;
  std::vector<std::vector<fit::FitResult>> results_;
  std::vector<std::vector<std::optional<CrossValidated>>> cross_validated_;
};

bool has_numbers(const data::Table& table, const std::string& name) {
  return table.has(name) && table.is_numeric(name);
}

bool all_present(const data::Table& table,
                 const std::vector<std::string>& columns,
                 std::size_t row) {
  return std::ranges::none_of(
      columns, [&](const std::string& name) { return std::isnan(table.numbers(name)[row]); });
}

/// Columns among those wanted that the table has with values that differ.
std::vector<std::string> varying_columns(const data::Table& table,
                                         const std::vector<std::string>& wanted,
                                         const std::vector<std::size_t>& rows,
                                         std::vector<std::string>& notes) {
  std::vector<std::string> result;
  for (const std::string& name : wanted) {
    if (!has_numbers(table, name)) continue;
    std::set<double> values;
    for (const std::size_t row : rows) {
      const double value = table.numbers(name)[row];
      if (!std::isnan(value)) values.insert(value);
      if (values.size() > 1) break;
    }
    if (values.size() > 1) {
      result.push_back(name);
    } else {
      notes.push_back(
          fmt::format("{} is {} for all of these trees: left out as a covariate.",
                      name,
                      values.empty() ? std::string("missing") : data::shortest(*values.begin())));
    }
  }
  return result;
}

std::vector<std::size_t> rows_of_species(const data::Table& table, const std::string& species) {
  std::vector<std::size_t> rows;
  const data::TextColumn column = table.labels("species");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool counts = !has_numbers(table, "core") || table.numbers("core")[row] == 1.0;
    if (counts && !column.is_missing(row) && column[row] == species) rows.push_back(row);
  }
  return rows;
}

std::vector<std::size_t> complete_rows(const data::Table& table,
                                       const std::vector<std::size_t>& rows,
                                       const std::vector<std::string>& columns) {
  std::vector<std::size_t> complete;
  for (const std::size_t row : rows) {
    if (all_present(table, columns, row)) complete.push_back(row);
  }
  return complete;
}

std::size_t count_groups(const data::Table& table, const std::string& group) {
  return table.labels(group).levels().size();
}

bool is_formula(const std::string& text) { return text.find('~') != std::string::npos; }

/// \throws UsageError if a candidate is neither in the catalogue nor a formula, or is for another
/// response
std::vector<BaseCandidate> candidates_of(const std::string& response,
                                         const Catalogue& catalogue,
                                         const StudyOptions& options) {
  std::vector<BaseCandidate> candidates;
  const auto chosen = options.candidates.find(response);
  if (chosen == options.candidates.end()) {
    for (const BaseModel* model : catalogue.candidates(response)) {
      candidates.push_back({.entry = model, .formula = model->formula});
    }
    return candidates;
  }
  for (const std::string& text : chosen->second) {
    BaseCandidate candidate{.formula = text};
    if (!is_formula(text)) {
      candidate.entry = &catalogue.find(text);
      candidate.formula = candidate.entry->formula;
    }
    if (data::parse_formula(candidate.formula).left != response) {
      throw UsageError(fmt::format("the candidate '{}' is no model of {}", text, response));
    }
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

/// Sets up one species and response: what it may use, and the rows that all of its fits share.
Work prepared(const data::Table& table,
              const Catalogue& catalogue,
              const StudyOptions& options,
              const std::string& species,
              const std::string& response) {
  Work work{.result = {.species = species, .response = response},
            .candidates = candidates_of(response, catalogue, options)};
  std::vector<std::string> columns{response};
  for (const BaseCandidate& candidate : work.candidates) {
    for (const std::string& name : candidate.columns(table)) columns.push_back(name);
  }
  if (!std::ranges::all_of(columns,
                           [&](const std::string& name) { return has_numbers(table, name); })) {
    return work;
  }
  const auto rows = complete_rows(table, rows_of_species(table, species), columns);
  work.covariates = varying_columns(table, options.covariates, rows, work.result.notes);
  columns.insert(columns.end(), work.covariates.begin(), work.covariates.end());
  work.result.rows = complete_rows(table, rows, columns);
  if (work.result.rows.size() < rows.size()) {
    work.result.notes.push_back(fmt::format("{} trees without structural unit were left out.",
                                            rows.size() - work.result.rows.size()));
  }
  work.table = table.select(work.result.rows);
  work.result.plots = count_groups(work.table, options.group);
  return work;
}

std::vector<std::string> species_of(const data::Table& table, const StudyOptions& options) {
  const data::TextColumn column = table.labels("species");
  if (options.species.empty()) return column.levels();
  for (const std::string& species : options.species) {
    if (column.code_of(species) == data::TextColumn::kMissingCode) {
      throw UsageError(fmt::format("there is no species '{}'; the species are {}",
                                   species,
                                   fmt::join(column.levels(), ", ")),
                       {.file = table.file()});
    }
  }
  return options.species;
}

void run_base(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  Level level("base models", works, study.options.criteria.base, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    level.add(i, base_trials(works[i].candidates, works[i].table));
  }
  level.run(study.options.threads, progress, study.stages);
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.base = level.candidates(i);
    if (const auto chosen = choose_base(result.base, study.options))
      result.ols = level.result(i, *chosen);
  }
}

/// Tests against the first candidate; a fit that failed has no likelihood to test.
void add_tests(std::vector<Candidate>& candidates) {
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    if (!candidates[i].fit.convergence.converged) continue;
    candidates[i].test = likelihood_ratio_test(candidates[i].fit, candidates[0].fit);
  }
}

/// Tries the chosen sub-model without its intercept, which some published models lack.
void run_without_intercept(std::vector<Work>& works,
                           Study& study,
                           const ProgressCallback& progress) {
  Level level("covariates alone", works, study.options.criteria.covariates, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    for (const Candidate& candidate : works[i].result.covariates) {
      if (!candidate.chosen) continue;
      if (auto trial = without_intercept(candidate, works[i].table)) level.add(i, {*trial});
    }
  }
  level.run(study.options.threads, progress, study.stages);
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    for (Candidate& candidate : level.candidates(i)) {
      // Not nested in level 1, so there is no likelihood-ratio test: the criterion alone decides.
      result.covariates.push_back(std::move(candidate));
      if (choose_covariates(result.covariates, study.options) == result.covariates.size() - 1) {
        result.with_covariates = level.result(i, 0);
      }
    }
  }
}

void run_covariates(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  Level level(
      "structural covariates", works, study.options.criteria.covariates, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    if (!works[i].result.ols || works[i].covariates.empty()) continue;
    level.add(i,
              covariate_trials(works[i].result.ols->fit,
                               works[i].covariates,
                               study.options.covariate_parameters,
                               works[i].table));
  }
  level.run(study.options.threads, progress, study.stages);
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.covariates = level.candidates(i);
    result.with_covariates = result.ols;
    add_tests(result.covariates);
    if (const auto chosen = choose_covariates(result.covariates, study.options)) {
      result.with_covariates = level.result(i, *chosen);
    }
  }
  run_without_intercept(works, study, progress);
}

/// A mixed model on the edge of its range is the best only where no other is left.
void note_edge(const fit::FittedModel& fit, std::vector<std::string>& notes) {
  if (fit.convergence.boundary.empty()) return;
  notes.push_back(
      fmt::format("Every mixed model ends on the edge of its range ({}): these plots do not tell "
                  "more effects apart.",
                  fmt::join(fit.convergence.boundary, "; ")));
}

void run_random_effects(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  Level level("random effects", works, study.options.criteria.random, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    const ResponseStudy& result = works[i].result;
    if (!result.with_covariates || result.plots < 2) continue;
    level.add(i,
              random_effect_trials(result.with_covariates->fit,
                                   study.options.group,
                                   study.options.maximum_random_effects));
  }
  level.run(study.options.threads, progress, study.stages);
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.random = level.candidates(i);
    if (const auto chosen = choose_random_effects(result.random, study.options)) {
      result.nlme = level.result(i, *chosen);
      note_edge(result.nlme->fit, result.notes);
    }
  }
}

void run_variance(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  Level level("variance functions", works, study.options.criteria.variance, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    for (const Candidate& candidate : works[i].result.random) {
      if (candidate.chosen)
        level.add(i, variance_trials(candidate, study.options.variance_functions));
    }
  }
  level.run(study.options.threads, progress, study.stages);
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.variance = level.candidates(i);
    add_tests(result.variance);
    if (const auto chosen = choose_variance(result.variance, study.options)) {
      result.nlme = level.result(i, *chosen);
    }
  }
}

/// The mixed model with b = 0 predicts a typical plot, which may be far from the mean of all plots.
void note_worse_populations(std::vector<Work>& works) {
  for (Work& work : works) {
    ResponseStudy& result = work.result;
    if (!result.ols || !result.nlme) continue;
    const double ols = result.ols->fit.population.r2;
    const double population = result.nlme->fit.population.r2;
    if (population >= ols - kNoticeablyWorse) continue;
    result.notes.push_back(
        fmt::format("For plots without measured trees the base model by least squares predicts "
                    "better (R2 {:.3f}) than the mixed model with random effects zero (R2 {:.3f}).",
                    ols,
                    population));
  }
}

void check_options(const Catalogue& catalogue, const StudyOptions& options) {
  std::set<std::string> known;
  for (const BaseModel& model : catalogue.models()) known.insert(model.response);
  for (const std::string& response : options.responses) {
    if (known.contains(response) || options.candidates.contains(response)) continue;
    throw UsageError(
        fmt::format("the catalogue has no models of '{}'; it has models of {}. Candidates of your "
                    "own can be given in a study.json",
                    response,
                    fmt::join(known, ", ")));
  }
  if (options.covariate_parameters < 1 || options.covariate_parameters > 2) {
    throw UsageError("covariates can be on one parameter at once, or on two");
  }
  if (!(options.significance > 0.0 && options.significance < 1.0)) {
    throw UsageError("a level of significance lies between 0 and 1");
  }
  if (!(options.equally_good >= 0.0)) {
    throw UsageError("models are equally good within a distance of 0 or more");
  }
  for (const std::string& text : options.variance_functions) fit::parse_variance_function(text);
}

void note_what_is_left_out(const data::Table& table, Study& study) {
  const bool has_any = std::ranges::any_of(
      study.options.covariates, [&](const std::string& name) { return has_numbers(table, name); });
  if (!has_any) {
    study.notes.emplace_back(
        "The inventory has no positions, so there are no structural units: level 2 was left out.");
  }
  for (const std::string& response : study.options.responses) {
    if (!has_numbers(table, response)) {
      study.notes.push_back(
          fmt::format("The inventory has no {}: its models were left out.", response));
    }
  }
}

}  // namespace

bool ResponseStudy::converged() const {
  if (nlme) return nlme->fit.convergence.converged;
  return plots < 2 && with_covariates && with_covariates->fit.convergence.converged;
}

std::string ResponseStudy::verdict() const {
  if (nlme) return nlme->fit.convergence.verdict;
  if (!ols) return "No base model converged.";
  if (plots < 2)
    return "There is one plot: level 3 was left out. " + with_covariates->fit.convergence.verdict;
  return "No mixed model converged; the least-squares model stands.";
}

std::size_t Study::fit_count() const {
  std::size_t count = 0;
  for (const StageTime& stage : stages) count += stage.fits;
  return count;
}

std::string criterion_text(Criterion criterion) {
  return std::string(kCriterionNames[static_cast<std::size_t>(criterion)]);
}

Criterion parse_criterion(std::string_view text) {
  const auto* const found = std::ranges::find(kCriterionNames, text);
  if (found == kCriterionNames.end()) {
    throw UsageError(
        fmt::format("'{}' is no criterion; there are {}", text, fmt::join(kCriterionNames, ", ")));
  }
  return static_cast<Criterion>(found - kCriterionNames.begin());
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
  note_what_is_left_out(table, study);
  std::vector<std::string> small;
  std::vector<Work> works;
  for (const std::string& species : species_of(table, options)) {
    for (const std::string& response : options.responses) {
      Work work = prepared(table, catalogue, options, species, response);
      const std::size_t trees = work.result.rows.size();
      if (trees >= options.minimum_trees) {
        works.push_back(std::move(work));
      } else if (has_numbers(table, response)) {
        small.push_back(fmt::format("{} {} ({})", species, response, trees));
      }
    }
  }
  if (!small.empty()) {
    study.notes.push_back(fmt::format("Too few trees for models (fewer than {}): {}.",
                                      options.minimum_trees,
                                      fmt::join(small, ", ")));
  }
  run_base(works, study, progress);
  run_covariates(works, study, progress);
  run_random_effects(works, study, progress);
  run_variance(works, study, progress);
  note_worse_populations(works);
  for (Work& work : works) study.results.push_back(std::move(work.result));
  return study;
}

}  // namespace silvafit::study
