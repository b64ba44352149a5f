// SPDX-License-Identifier: MIT
#include "silvafit/fit/cross_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "resampling/resampled_data.hpp"
#include "result/variance_shares.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/fit/calibrated_fit.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/nonlinear_model.hpp"
#include "silvafit/fit/prediction.hpp"

namespace silvafit::fit {
namespace {

std::string group_column(const FittedModel& fit, const CrossValidationOptions& options) {
  if (!options.group.empty()) return options.group;
  const ModelSpecification& specification = fit.specification;
  if (!specification.random.empty()) return specification.random.front().group;
  throw UsageError(
      "cross-validation leaves out groups, and this model has none; name their column, for example "
      "plot");
}

/// The fold of each group: assigned in turn after shuffling.
std::vector<std::size_t> dealt(std::size_t groups, std::size_t folds, std::uint64_t seed) {
  std::vector<std::size_t> order(groups);
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (folds < groups) {
    Random random(seed);
    for (std::size_t k = groups; k > 1; --k) std::swap(order[k - 1], order[random.below(k)]);
  }
  std::vector<std::size_t> fold_of(groups);
  for (std::size_t k = 0; k < groups; ++k) fold_of[order[k]] = k % folds;
  return fold_of;
}

/// The observations of a fit and their groups.
struct Observations {
  data::Table table{};  ///< their rows
  data::TextColumn labels{};
};

Observations observations_of(const data::Table& table,
                             const std::vector<std::size_t>& rows,
                             const std::string& group) {
  Observations result{.table = table.select(rows)};
  result.labels = result.table.labels(group);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (!result.labels.is_missing(row)) continue;
    throw InputError("the group is missing", data::place_of(table, rows[row], group));
  }
  return result;
}

/// The predictions of the rows of one fold.
struct FoldPrediction {
  VectorXd predicted{};
  VectorXd calibrated{};
  VectorXd log_density{};
  std::string failure{};  ///< empty if the fit converged
};

std::string bytes_of_fold(const FoldPrediction& fold) {
  std::string bytes;
  for (const VectorXd* const values : {&fold.predicted, &fold.calibrated, &fold.log_density}) {
    append_numbers(values->data(), static_cast<std::size_t>(values->size()), bytes);
  }
  append_text(fold.failure, bytes);
  return bytes;
}

FoldPrediction fold_from(std::string_view bytes) {
  FoldPrediction fold;
  for (VectorXd* const values : {&fold.predicted, &fold.calibrated, &fold.log_density}) {
    const std::vector<double> numbers = take_numbers(bytes);
    *values = Eigen::Map<const VectorXd>(numbers.data(), static_cast<Index>(numbers.size()));
  }
  fold.failure = take_text(bytes);
  return fold;
}

/// \param rows  of one fold, in the order of the table; the model sorts them by its own groups
VectorXd log_densities(const FittedModel& fit, const data::Table& rows, const Prediction& at) {
  const NonlinearModel model(fit.specification, rows);
  const VectorXd effects = variance_of_effects(fit, model, model.curve_at(fit.estimate).jacobian);
  VectorXd result = VectorXd::Constant(at.value.size(), kNaN);
  for (Index i = 0; i < model.observations(); ++i) {
    const auto row = static_cast<Index>(model.rows()[static_cast<std::size_t>(i)]);
    const double variance = effects[i] + std::pow(at.residual_sd[row], 2);
    const double error = model.response()[i] - at.value[row];
    result[row] = -0.5 * (std::log(2.0 * std::numbers::pi * variance) + error * error / variance);
  }
  return result;
}

/// The observations that are used as measured if their group is left out: some of each group of
/// the random effects (of the finer grouping) or, with crossed ones, of each group that is left
/// out.
std::vector<bool> drawn_measured(const NonlinearModel& model,
                                 const data::TextColumn& left_out,
                                 const CrossValidationOptions& options) {
  std::vector<bool> is_measured(static_cast<std::size_t>(model.observations()), false);
  if (options.measured == 0) return is_measured;
  std::vector<std::vector<std::size_t>> trees_of;
  if (model.crossed() != nullptr) {
    trees_of.resize(left_out.levels().size());
    for (std::size_t row = 0; row < left_out.size(); ++row) {
      trees_of[left_out.code(row)].push_back(row);
    }
  } else {
    for (Index g = 0; g < model.group_count(); ++g) {
      trees_of.emplace_back(
          static_cast<std::size_t>(model.group_begin(g + 1) - model.group_begin(g)));
      std::iota(trees_of.back().begin(),
                trees_of.back().end(),
                static_cast<std::size_t>(model.group_begin(g)));
    }
  }
  for (std::size_t g = 0; g < trees_of.size(); ++g) {
    std::vector<std::size_t>& trees = trees_of[g];
    Random random(options.seed, g + 1);
    for (std::size_t k = 0; k < std::min(options.measured, trees.size()); ++k) {
      std::swap(trees[k], trees[k + random.below(trees.size() - k)]);
      is_measured[trees[k]] = true;
    }
  }
  return is_measured;
}

/// Predictions of the trees of left-out groups that are not measured, from those that are. Crossed
/// groups that are in the fit, such as years, have what is known of them by the fit.
VectorXd calibrated(const FittedModel& fit,
                    const data::Table& left_out,
                    const std::vector<bool>& is_measured) {
  data::Table known = left_out;
  const std::string& response = fit.specification.formula.left;
  const auto values = left_out.numbers(response);
  std::vector<double> measured(values.begin(), values.end());
  for (std::size_t row = 0; row < measured.size(); ++row) {
    if (!is_measured[row]) measured[row] = data::kMissing;
  }
  known.set(response, std::move(measured));
  const bool has_seen = are_crossed(fit.specification.random);
  const CalibrationOptions options{.seen_groups =
                                       has_seen ? SeenGroups::kFitted : SeenGroups::kNew};
  const Calibration calibration = calibrate(fit, known, options);
  VectorXd result = predict(with_groups(fit, calibration), left_out, Level::kConditional).value;
  for (std::size_t row = 0; row < is_measured.size(); ++row) {
    if (is_measured[row]) result[static_cast<Index>(row)] = kNaN;
  }
  return result;
}

/// \param is_measured  by row of what is left out; empty: nothing is calibrated
FoldPrediction predicted(const FittedModel& fit,
                         const data::Table& training,
                         const data::Table& left_out,
                         const std::vector<bool>& is_measured,
                         FitModelOptions options) {
  const auto n = static_cast<Index>(left_out.rows());
  FoldPrediction result{.predicted = VectorXd::Constant(n, kNaN),
                        .calibrated = VectorXd::Constant(n, kNaN),
                        .log_density = VectorXd::Constant(n, kNaN)};
  options.from = &fit;
  try {
    const FittedModel refit = fit_model(fit.specification, training, options).fit;
    if (!refit.convergence.converged()) {
      result.failure = refit.convergence.verdict();
      return result;
    }
    const Prediction prediction = predict(refit, left_out, Level::kPopulation);
    result.predicted = prediction.value;
    result.log_density = log_densities(refit, left_out, prediction);
    if (!is_measured.empty()) result.calibrated = calibrated(refit, left_out, is_measured);
  } catch (const Error& error) {
    result.failure = error.message();
  }
  return result;
}

/// Statistics of the observations that have a prediction.
/// \param where  observations without a value here are skipped, too
FitStatistics statistics_of(const VectorXd& observed,
                            const VectorXd& predicted,
                            const VectorXd& where,
                            std::size_t& count) {
  std::vector<Index> known;
  for (Index i = 0; i < predicted.size(); ++i) {
    if (std::isfinite(predicted[i]) && std::isfinite(where[i])) known.push_back(i);
  }
  count = known.size();
  if (known.empty()) return {};
  return fit_statistics(VectorXd(observed(known)), VectorXd(predicted(known)));
}

void summarize(CrossValidation& result, const VectorXd& log_density) {
  result.statistics =
      statistics_of(result.observed, result.predicted, result.predicted, result.predicted_count);
  const auto is_known = log_density.array().isFinite();
  result.density_count = static_cast<std::size_t>(is_known.count());
  result.log_density = is_known.any() ? is_known.select(log_density.array(), 0.0).sum() /
                                            static_cast<double>(is_known.count())
                                      : kNaN;
  result.calibrated_statistics =
      statistics_of(result.observed, result.calibrated, result.predicted, result.calibrated_count);
  result.uncalibrated_statistics =
      statistics_of(result.observed, result.predicted, result.calibrated, result.calibrated_count);
}

std::size_t fold_count(const CrossValidation& result, const CrossValidationOptions& options) {
  if (result.groups < 2) {
    throw UsageError(
        fmt::format("cross-validation needs at least two groups; {} has one", result.group));
  }
  const std::size_t folds =
      options.folds == 0 ? result.groups : std::min(options.folds, result.groups);
  if (folds < 2) throw UsageError("cross-validation needs at least two folds");
  return folds;
}

/// Rows of the observations that are in each fold; the others, nearly all of them, are found when
/// the fold is fitted, so that memory does not grow with the number of folds.
std::vector<std::vector<std::size_t>> rows_of_folds(const std::vector<std::size_t>& fold,
                                                    std::size_t folds) {
  std::vector<std::vector<std::size_t>> rows(folds);
  for (std::size_t row = 0; row < fold.size(); ++row) rows[fold[row]].push_back(row);
  return rows;
}

std::vector<std::size_t> rows_outside(const std::vector<std::size_t>& fold, std::size_t k) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < fold.size(); ++row) {
    if (fold[row] != k) rows.push_back(row);
  }
  return rows;
}

/// \param fold  of each row
/// \param left_out  rows of each fold
std::vector<FoldPrediction> predicted_folds(const FittedModel& fit,
                                            const data::Table& observations,
                                            const std::vector<std::size_t>& fold,
                                            const std::vector<std::vector<std::size_t>>& left_out,
                                            const std::vector<bool>& is_measured,
                                            const CrossValidationOptions& options) {
  const FitModelOptions refit = refit_options(fit, options.refit);
  std::atomic<std::size_t> done{0};
  const auto predict_fold = [&](std::size_t k) {
    std::vector<bool> measured;
    if (options.measured > 0) {
      for (const std::size_t row : left_out[k]) measured.push_back(is_measured[row]);
    }
    const FoldPrediction result = predicted(fit,
                                            observations.select(rows_outside(fold, k)),
                                            observations.select(left_out[k]),
                                            measured,
                                            refit);
    if (options.progress) options.progress(++done, left_out.size());
    return bytes_of_fold(result);
  };
  std::vector<FoldPrediction> folds;
  for (const std::string& bytes : farm(left_out.size(), options.threads, predict_fold)) {
    folds.push_back(fold_from(bytes));
  }
  return folds;
}

/// Copies the predictions of each fold to its rows.
void collect(const std::vector<FoldPrediction>& folds,
             const std::vector<std::vector<std::size_t>>& left_out,
             CrossValidation& result) {
  result.predicted = VectorXd::Constant(result.observed.size(), kNaN);
  result.calibrated = result.predicted;
  VectorXd log_density = result.predicted;
  for (std::size_t k = 0; k < folds.size(); ++k) {
    for (std::size_t i = 0; i < left_out[k].size(); ++i) {
      const auto row = static_cast<Index>(left_out[k][i]);
      result.predicted[row] = folds[k].predicted[static_cast<Index>(i)];
      result.calibrated[row] = folds[k].calibrated[static_cast<Index>(i)];
      log_density[row] = folds[k].log_density[static_cast<Index>(i)];
    }
  }
  summarize(result, log_density);
}

}  // namespace

CrossValidation cross_validate(const FittedModel& fit,
                               const data::Table& table,
                               const CrossValidationOptions& options) {
  if (!fit.convergence.converged()) {
    throw UsageError("a fit that has not converged cannot be cross-validated");
  }
  CrossValidation result{.group = group_column(fit, options), .seed = options.seed};
  if (options.measured > 0 && !fit.has_random_effects()) {
    throw UsageError("a model without random effects cannot be calibrated with measured trees");
  }
  const NonlinearModel model(fit.specification, table);
  result.measured = options.measured;
  result.rows = model.rows();
  result.observed = model.response();
  const Observations all = observations_of(table, result.rows, result.group);
  const std::vector<std::string>& labels = all.labels.levels();
  result.groups = labels.size();
  result.folds = fold_count(result, options);
  const std::vector<std::size_t> fold_of = dealt(result.groups, result.folds, options.seed);
  for (std::size_t row = 0; row < all.labels.size(); ++row) {
    result.fold.push_back(fold_of[all.labels.code(row)]);
  }
  const std::vector<std::vector<std::size_t>> left_out = rows_of_folds(result.fold, result.folds);
  const std::vector<FoldPrediction> folds = predicted_folds(
      fit, all.table, result.fold, left_out, drawn_measured(model, all.labels, options), options);
  collect(folds, left_out, result);
  for (std::size_t k = 0; k < folds.size(); ++k) {
    if (folds[k].failure.empty()) continue;
    FailedFold failed{.verdict = folds[k].failure};
    for (std::size_t g = 0; g < labels.size(); ++g) {
      if (fold_of[g] == k) failed.groups.push_back(labels[g]);
    }
    result.failed.push_back(std::move(failed));
  }
  return result;
}

}  // namespace silvafit::fit
