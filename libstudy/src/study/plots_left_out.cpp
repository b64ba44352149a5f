// SPDX-License-Identifier: MIT
#include "study/plots_left_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <span>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/fit/cross_validation.hpp"
#include "silvafit/fit/fit_statistics.hpp"

namespace silvafit::study {
namespace {

/// The usual number; each costs a refit of every level, which starts from the fit of all plots.
constexpr std::size_t kFolds = 10;
/// One-sided level of significance.
constexpr double kSignificance = 0.05;
/// A difference of this share of the error is reported even if it is not significant.
constexpr double kMuchWorse = 0.05;
/// With many plots any difference is significant; one below this share is negligible.
constexpr double kWorse = 0.01;

bool can_be_left_out(const std::optional<fit::FitResult>& fit) {
  return fit && fit->fit.convergence.converged();
}

/// Errors of the trees of the table, NaN for folds without a fit; empty without any fit.
Eigen::VectorXd errors_of(const std::optional<fit::FitResult>& fit,
                          const data::Table& table,
                          const std::string& group,
                          const std::function<void()>& on_fit) {
  if (!can_be_left_out(fit)) return {};
  fit::CrossValidationOptions options{.folds = kFolds, .group = group, .measured = 0};
  options.threads = 1;  // the models are parallel already
  if (on_fit) options.progress = [&on_fit](std::size_t, std::size_t) { on_fit(); };
  try {
    const fit::CrossValidation result = fit::cross_validate(fit->fit, table, options);
    if (result.predicted_count == 0) return {};
    Eigen::VectorXd errors =
        Eigen::VectorXd::Constant(static_cast<Eigen::Index>(table.rows()), kNaN);
    for (std::size_t i = 0; i < result.rows.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      errors[static_cast<Eigen::Index>(result.rows[i])] =
          result.predicted[at] - result.observed[at];
    }
    return errors;
  } catch (const Error&) {
    // A single plot cannot be left out.
    return {};
  }
}

/// Rows of the table that all of the models predict.
std::vector<Eigen::Index> rows_in_all(const std::vector<const Eigen::VectorXd*>& errors) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < errors.front()->size(); ++row) {
    const bool has_all = std::ranges::all_of(errors, [row](const Eigen::VectorXd* each) {
      return each->size() == 0 || std::isfinite((*each)[row]);
    });
    if (has_all) rows.push_back(row);
  }
  return rows;
}

/// R2 and RMSE of the predictions with these errors, as those of all fits.
fit::FitStatistics statistics_of(const Eigen::VectorXd& errors,
                                 const std::vector<Eigen::Index>& rows,
                                 std::span<const double> observed) {
  if (errors.size() == 0) return {};
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    values[static_cast<Eigen::Index>(i)] = observed[static_cast<std::size_t>(rows[i])];
  }
  return fit::fit_statistics(values, values + errors(rows));
}

/// The upper quantile of t for the plots of the rows.
double critical_t(const std::vector<std::size_t>& plot) {
  std::vector<std::size_t> plots = plot;
  std::ranges::sort(plots);
  const auto freedom =
      static_cast<double>(std::unique(plots.begin(), plots.end()) - plots.begin()) - 1.0;
  if (freedom < 1.0) return std::numeric_limits<double>::infinity();
  return boost::math::quantile(boost::math::complement(
      boost::math::students_t_distribution<double>(freedom), kSignificance));
}

/// Errors of the trees of each model; empty without the model.
struct ErrorsOfLevels {
  Eigen::VectorXd nlme;
  Eigen::VectorXd ols;
  Eigen::VectorXd covariates;
};

std::optional<LeftOutPlots> compared(const StudiedTrees& study, const ErrorsOfLevels& errors) {
  const auto& [result, table] = study;
  const auto& [nlme, ols, covariates] = errors;
  if (nlme.size() == 0 || ols.size() == 0) return std::nullopt;
  const std::vector<Eigen::Index> rows = rows_in_all({&nlme, &ols, &covariates});
  if (rows.empty()) return std::nullopt;
  const std::span<const double> observed = table.numbers(result.response);
  const fit::FitStatistics of_ols = statistics_of(ols, rows, observed);
  const fit::FitStatistics of_covariates = statistics_of(covariates, rows, observed);
  const fit::FitStatistics of_nlme = statistics_of(nlme, rows, observed);
  LeftOutPlots left_out{.folds = std::min(kFolds, result.plots),
                        .trees = rows.size(),
                        .trees_without = table.rows() - rows.size(),
                        .rmse_ols = of_ols.rmse,
                        .rmse_covariates = of_covariates.rmse,
                        .rmse_nlme = of_nlme.rmse,
                        .r2_ols = of_ols.r2,
                        .r2_covariates = of_covariates.r2,
                        .r2_nlme = of_nlme.r2};
  const bool is_better_with = left_out.rmse_covariates < left_out.rmse_ols;
  const Eigen::VectorXd& least_squares = is_better_with ? covariates : ols;
  const data::TextColumn labels = table.labels(result.group);
  std::vector<std::size_t> plot;
  for (const Eigen::Index row : rows) plot.push_back(labels.code(static_cast<std::size_t>(row)));
  left_out.t = paired_t(nlme(rows), least_squares(rows), plot);
  const double least = is_better_with ? left_out.rmse_covariates : left_out.rmse_ols;
  const double share = left_out.rmse_nlme / least - 1.0;
  left_out.is_worse = share > kMuchWorse || (share > kWorse && left_out.t > critical_t(plot));
  return left_out;
}

}  // namespace

double paired_t(const Eigen::VectorXd& first,
                const Eigen::VectorXd& second,
                const std::vector<std::size_t>& plot) {
  if (plot.empty()) return 0.0;
  const auto count = static_cast<Eigen::Index>(*std::ranges::max_element(plot)) + 1;
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(count);
  std::vector<bool> has_trees(static_cast<std::size_t>(count), false);
  for (std::size_t i = 0; i < plot.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    sums[static_cast<Eigen::Index>(plot[i])] += first[at] * first[at] - second[at] * second[at];
    has_trees[plot[i]] = true;
  }
  const auto n = static_cast<double>(std::ranges::count(has_trees, true));
  const double mean = sums.sum() / n;
  double squares = 0.0;
  for (Eigen::Index k = 0; k < count; ++k) {
    if (has_trees[static_cast<std::size_t>(k)]) squares += std::pow(sums[k] - mean, 2);
  }
  // Differences that are all equal, mostly zero, have no variance.
  if (n < 2.0 || squares == 0.0) return 0.0;
  return mean / std::sqrt(squares / (n - 1.0) / n);
}

std::size_t left_out_fits(const ResponseStudy& result) {
  if (!can_be_left_out(result.nlme) || !result.has_groups()) return 0;
  const auto levels = static_cast<std::size_t>(1 + can_be_left_out(result.ols) +
                                               can_be_left_out(result.with_covariates));
  return levels * std::min(kFolds, result.plots);
}

std::vector<std::optional<LeftOutPlots>> cross_validate_levels(
    const std::vector<StudiedTrees>& studies,
    unsigned threads,
    const std::function<void()>& on_fit) {
  // Mixed models, whose fits take longest, are first, so that they are spread over the processes.
  const std::array levels{
      &ResponseStudy::nlme, &ResponseStudy::ols, &ResponseStudy::with_covariates};
  const std::size_t count = studies.size();
  const auto bytes = farm(levels.size() * count, threads, [&](std::size_t task) {
    const auto& [result, table] = studies[task % count];
    std::string own;
    if (left_out_fits(result) == 0) return own;
    const Eigen::VectorXd errors =
        errors_of(result.*levels[task / count], table, result.group, on_fit);
    append_numbers(errors.data(), static_cast<std::size_t>(errors.size()), own);
    return own;
  });
  const auto errors_at = [&](std::size_t task) {
    std::string_view rest = bytes[task];
    const std::vector<double> errors = rest.empty() ? std::vector<double>() : take_numbers(rest);
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(errors.data(), static_cast<Eigen::Index>(errors.size())));
  };
  std::vector<std::optional<LeftOutPlots>> results;
  for (std::size_t i = 0; i < count; ++i) {
    results.push_back(compared(studies[i],
                               {.nlme = errors_at(i),
                                .ols = errors_at(count + i),
                                .covariates = errors_at(2 * count + i)}));
  }
  return results;
}

std::string doubt_of(const LeftOutPlots& left_out, const std::string& unit) {
  if (!left_out.is_worse) return "";
  const bool is_better_with = left_out.rmse_covariates < left_out.rmse_ols;
  const double least = is_better_with ? left_out.rmse_covariates : left_out.rmse_ols;
  const std::string of = unit.empty() ? "" : " " + unit;
  return fmt::format(
      "For plots without measured trees the mixed model predicts worse than least squares{}: "
      "RMSE {:.3f}{} against {:.3f}{} for plots left out ({} folds). Use least squares for such "
      "plots.",
      is_better_with ? " with covariates" : "",
      left_out.rmse_nlme,
      of,
      least,
      of,
      left_out.folds);
}

}  // namespace silvafit::study
