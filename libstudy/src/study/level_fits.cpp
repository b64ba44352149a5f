// SPDX-License-Identifier: MIT
#include "study/level_fits.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/fit/cross_validation.hpp"
#include "silvafit/fit/fit_json.hpp"

namespace silvafit::study {
namespace {

/// A fit as bytes, for other processes.
std::string bytes_of_result(const fit::FitResult& result) {
  std::string bytes;
  append_text(fit::to_json(result.fit), bytes);
  const std::vector<double> rows(result.rows.begin(), result.rows.end());
  append_numbers(rows.data(), rows.size(), bytes);
  for (const Eigen::VectorXd* const values :
       {&result.fitted_population, &result.fitted_conditional, &result.residual_sd}) {
    append_numbers(values->data(), static_cast<std::size_t>(values->size()), bytes);
  }
  return bytes;
}

/// The same with its cross-validation.
std::string bytes_of_candidate(const fit::FitResult& result,
                               const std::optional<CrossValidated>& cross_validated) {
  std::vector<double> numbers;
  if (cross_validated) {
    numbers = {cross_validated->rmse,
               cross_validated->standard_error,
               static_cast<double>(cross_validated->folds),
               static_cast<double>(cross_validated->failed),
               static_cast<double>(cross_validated->measured)};
  }
  std::string bytes;
  append_numbers(numbers.data(), numbers.size(), bytes);
  return bytes + bytes_of_result(result);
}

CrossValidated cross_validated_from(const std::vector<double>& numbers) {
  return {.rmse = numbers.at(0),
          .standard_error = numbers.at(1),
          .folds = static_cast<std::size_t>(numbers.at(2)),
          .failed = static_cast<std::size_t>(numbers.at(3)),
          .measured = static_cast<std::size_t>(numbers.at(4))};
}

fit::FitResult result_from(std::string_view bytes) {
  fit::FitResult result{.fit = fit::from_json(take_text(bytes), "fit of another process")};
  for (const double row : take_numbers(bytes)) {
    result.rows.push_back(static_cast<std::size_t>(row));
  }
  for (Eigen::VectorXd* const values :
       {&result.fitted_population, &result.fitted_conditional, &result.residual_sd}) {
    const std::vector<double> numbers = take_numbers(bytes);
    *values = Eigen::Map<const Eigen::VectorXd>(numbers.data(),
                                                static_cast<Eigen::Index>(numbers.size()));
  }
  return result;
}

fit::FitResult failed_fit(const Trial& trial, const std::string& reason) {
  fit::FitResult result{.fit = fit::FittedModel(trial.specification)};
  result.fit.model = trial.model;
  if (trial.options.method) result.fit.method = *trial.options.method;
  result.fit.set_missing(trial.specification);
  result.fit.convergence.find({.names = {reason}});
  return result;
}

/// Coefficients with random effects, of all groupings.
std::vector<std::string> random_effects_of(const Trial& trial) {
  std::vector<std::string> result;
  for (const fit::RandomEffects& term : trial.specification.random) {
    result.insert(result.end(), term.coefficients.begin(), term.coefficients.end());
  }
  return result;
}

/// All fits of a study are done here: candidates by run() with one start each, chosen models by
/// result() from all starts.
/// \param from  a fit to other trees to start from, if given
fit::FitResult fit_trial(const Trial& trial,
                         const data::Table& table,
                         fit::SearchEffort effort,
                         const fit::FittedModel* from = nullptr,
                         unsigned threads = 1) {
  try {
    fit::FitModelOptions options = trial.options;
    options.threads = threads;
    options.from = from;
    options.effort = effort;
    fit::FitResult result = fit::fit_model(trial.specification, table, options);
    result.fit.model = trial.model;
    return result;
  } catch (const Error& error) {
    return failed_fit(trial, error.message());
  }
}

/// Number of trees of a left-out plot that calibrate the prediction of its other trees: as many as
/// inventories often measure.
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
  // Boundary (singular) fits are rejected; if all are, the simplest one is used.
  if (!fit.convergence.converged() || fit.convergence.has_boundary()) return std::nullopt;
  // A single plot cannot be left out.
  if (table.labels(group).levels().size() < 2) return std::nullopt;
  const std::size_t measured = fit.has_random_effects() ? kCalibratingTrees : 0;
  // The tasks of a level are parallel already.
  const fit::CrossValidation result =
      fit::cross_validate(fit, table, {.group = group, .measured = measured, .threads = 1});
  return CrossValidated{
      .rmse = measured > 0 ? result.calibrated_statistics.rmse : result.statistics.rmse,
      .standard_error = error_between_folds(result),
      .folds = result.folds,
      .failed = result.failed.size(),
      .measured = measured};
}

}  // namespace

LevelFits::LevelFits(std::string name,
                     const std::vector<Work>& works,
                     Criterion criterion,
                     std::string group)
    : name_(std::move(name)),
      works_(works),
      criterion_(criterion),
      group_(std::move(group)),
      results_(works.size()),
      whole_(works.size()),
      cross_validated_(works.size()) {}

void LevelFits::add(std::size_t work, std::vector<Trial> trials) {
  for (Trial& trial : trials) {
    tasks_.push_back({.trial = std::move(trial), .work = work, .position = results_[work].size()});
    results_[work].emplace_back(
        fit::FitResult{.fit = fit::FittedModel(tasks_.back().trial.specification)});
    cross_validated_[work].emplace_back();
  }
}

void LevelFits::add_known(std::size_t work,
                          Trial trial,
                          fit::FittedModel compared,
                          fit::FitResult final) {
  tasks_.push_back({.trial = std::move(trial),
                    .work = work,
                    .position = results_[work].size(),
                    .known = std::move(final)});
  results_[work].emplace_back(fit::FitResult{.fit = std::move(compared)});
  cross_validated_[work].emplace_back();
}

std::vector<std::vector<std::size_t>> LevelFits::waves() const {
  std::vector<std::vector<std::size_t>> result;
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    const std::size_t wave = random_effects_of(tasks_[i].trial).size();
    if (wave >= result.size()) result.resize(wave + 1);
    result[wave].push_back(i);
  }
  return result;
}

void LevelFits::run(unsigned threads,
                    const ProgressCallback& progress,
                    std::vector<StageTime>& stages) {
  const auto start = std::chrono::steady_clock::now();
  const auto is_known = [](const Task& task) { return task.known.has_value(); };
  const auto known = static_cast<std::size_t>(std::ranges::count_if(tasks_, is_known));
  const std::size_t all = tasks_.size() - known;
  std::atomic<std::size_t> done{0};
  for (const std::vector<std::size_t>& wave : waves()) {
    std::vector<char> is_own(wave.size(), 0);
    const auto results = farm(wave.size(), threads, [&](std::size_t i) {
      const Task& task = tasks_[wave[i]];
      run_task(task);
      is_own[i] = 1;
      if (!is_known(task)) {
        const std::size_t count = ++done;
        if (progress) progress(name_, count, all);
      }
      return Ranks::of_process().size() == 1 ? std::string() : bytes_of_task(task);
    });
    for (std::size_t i = 0; i < wave.size(); ++i) {
      if (is_own[i] == 0) take_bytes(tasks_[wave[i]], results[i]);
    }
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  stages.push_back({.name = name_, .seconds = seconds.count(), .fits = all});
}

void LevelFits::run_task(const Task& task) {
  const data::Table& table = works_[task.work].compared_trees();
  std::optional<CrossValidated>& validated = cross_validated_[task.work][task.position];
  // Before the result is stored: another thread may replace it by its fit alone (forget_worst).
  const auto validate = [&](const fit::FittedModel& fit) {
    if (criterion_ == Criterion::kCrossValidation) validated = cross_validated(fit, table, group_);
  };
  if (task.known) return validate(results_[task.work][task.position].fit);
  const auto effort =
      contains_failure(task) ? fit::SearchEffort::kBrief : fit::SearchEffort::kQuick;
  fit::FitResult result = fit_trial(task.trial, table, effort, task.trial.options.from);
  validate(result.fit);
  take(task, std::move(result));
}

bool LevelFits::contains_failure(const Task& task) {
  const std::lock_guard lock(taking_);
  const std::vector<std::string> effects = random_effects_of(task.trial);
  return std::ranges::any_of(tasks_, [&](const Task& other) {
    const std::vector<std::string> fewer = random_effects_of(other.trial);
    if (other.work != task.work || fewer.size() >= effects.size()) return false;
    const bool is_contained = std::ranges::all_of(fewer, [&](const std::string& effect) {
      return std::ranges::find(effects, effect) != effects.end();
    });
    const fit::Convergence& of = results_[other.work][other.position].fit.convergence;
    return is_contained && (!of.converged() || of.has_boundary());
  });
}

std::string LevelFits::bytes_of_task(const Task& task) {
  const std::lock_guard lock(taking_);
  return bytes_of_candidate(results_[task.work][task.position],
                            cross_validated_[task.work][task.position]);
}

/// The result of another process.
void LevelFits::take_bytes(const Task& task, std::string_view bytes) {
  const std::vector<double> criterion = take_numbers(bytes);
  if (!criterion.empty()) {
    cross_validated_[task.work][task.position] = cross_validated_from(criterion);
  }
  if (!task.known) take(task, result_from(bytes));
}

/// Values of each observation need much memory and are needed for the chosen fit only.
void LevelFits::take(const Task& task, fit::FitResult result) {
  constexpr std::size_t kWhole = 3;
  const std::lock_guard lock(taking_);
  results_[task.work][task.position] = std::move(result);
  whole_[task.work].push_back(task.position);
  if (whole_[task.work].size() > kWhole) forget_worst(task.work);
}

void LevelFits::forget_worst(std::size_t work) {
  std::vector<std::size_t>& whole = whole_[work];
  const auto worst = std::ranges::max_element(whole, {}, [&](std::size_t position) {
    const double aic = results_[work][position].fit.aic();
    return std::isnan(aic) ? std::numeric_limits<double>::infinity() : aic;
  });
  fit::FittedModel fit = std::move(results_[work][*worst].fit);
  results_[work][*worst] = {.fit = std::move(fit)};
  whole.erase(worst);
}

const LevelFits::Task& LevelFits::task_of(std::size_t work, std::size_t position) const {
  return *std::ranges::find_if(
      tasks_, [&](const Task& task) { return task.work == work && task.position == position; });
}

std::vector<fit::FitResult> LevelFits::results(const std::vector<Place>& places,
                                               unsigned threads) const {
  std::vector<std::optional<fit::FitResult>> own(places.size());
  // A few long fits are left at the end of a level: threads without one help with those.
  const std::size_t ranks = Ranks::of_process().size();
  const std::size_t own_count = std::max<std::size_t>(1, (places.size() + ranks - 1) / ranks);
  const auto each = std::max(1U, static_cast<unsigned>(worker_count(threads) / own_count));
  const auto bytes = farm(places.size(), threads, [&](std::size_t i) {
    own[i] = result(places[i], each);
    return Ranks::of_process().size() == 1 ? std::string() : bytes_of_result(*own[i]);
  });
  std::vector<fit::FitResult> all;
  for (std::size_t i = 0; i < places.size(); ++i) {
    all.push_back(own[i] ? *std::move(own[i]) : result_from(bytes[i]));
  }
  return all;
}

fit::FitResult LevelFits::result(const Place& place, unsigned threads) const {
  using enum fit::SearchEffort;
  const auto [work, position] = place;
  const fit::FitResult& known = results_[work][position];
  const Task& task = task_of(work, position);
  if (task.known) return *task.known;
  const Trial& trial = task.trial;
  const data::Table& table = works_[work].table;
  if (works_[work].is_sampled()) return fit_trial(trial, table, kQuick, &known.fit, threads);
  if (!trial.specification.random.empty()) {
    return fit_trial(trial, table, kThorough, nullptr, threads);
  }
  if (std::ranges::find(whole_[work], position) != whole_[work].end()) return known;
  fit::FitResult again = fit_trial(trial, table, kQuick);
  again.fit = known.fit;
  return again;
}

std::vector<Candidate> LevelFits::candidates(std::size_t work) const {
  std::vector<Candidate> list;
  for (const Task& task : tasks_) {
    if (task.work != work) continue;
    list.push_back({.terms = task.trial.terms,
                    .fit = results_[work][task.position].fit,
                    .cross_validated = cross_validated_[work][task.position]});
  }
  return list;
}

}  // namespace silvafit::study
