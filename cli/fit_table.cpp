// SPDX-License-Identifier: MIT
#include "fit_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace silvafit::cli {
namespace {

using Eigen::Index;
using fit::FittedModel;
using Kind = fit::VarianceFunction::Kind;

std::string number(double value) { return std::isnan(value) ? "-" : fmt::format("{:.6g}", value); }

/// Below the smallest difference of doubles near 1, p-values are noise.
std::string p_text(double value) {
  constexpr double kNoise = 2e-16;
  if (std::isnan(value)) return "-";
  return value < kNoise ? "< 2e-16" : fmt::format("{:.3g}", value);
}

std::size_t widest(const std::vector<std::string>& names, std::size_t at_least) {
  for (const std::string& name : names) at_least = std::max(at_least, name.size());
  return at_least;
}

void print_model(const FittedModel& fit) {
  const fit::ModelSpecification& specification = fit.specification;
  fmt::print("{}{}\n", fit.model.empty() ? "" : fit.model + "  ", specification.formula.text);
  for (const fit::ParameterModel& parameter : specification.parameters) {
    if (parameter.text() != "1") fmt::print("  {} ~ {}\n", parameter.name, parameter.text());
  }
  if (fit.has_random_effects()) {
    fmt::print("  random: {} | {}, {} covariance\n",
               fmt::join(fit.random_names, " + "),
               specification.random->group,
               fit::covariance_text(specification.covariance));
  }
  if (specification.variance.kind != Kind::kNone) {
    fmt::print("  variance: {}\n", specification.variance.text());
  }
  fmt::print("{}\n\n", fit.convergence.verdict);
  fmt::print("method {}, {} rows", fit::method_text(fit.method), fit.observations);
  if (fit.excluded > 0) fmt::print(" ({} more with missing values)", fit.excluded);
  if (fit.has_random_effects()) fmt::print(", {} groups", fit.group_labels.size());
  fmt::print(", {:.3g} s\n\n", fit.seconds);
}

void print_fixed_effects(const FittedModel& fit) {
  const std::size_t width = widest(fit.coefficient_names, 13);
  const Eigen::VectorXd errors = fit.standard_errors();
  const Eigen::VectorXd t = fit.t_values();
  const Eigen::VectorXd p = fit.p_values();
  fmt::print("{:<{}} {:>12} {:>12} {:>10} {:>9}\n",
             "coefficient",
             width,
             "estimate",
             "std. error",
             "t",
             "p");
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    const auto j = static_cast<Index>(k);
    fmt::print("{:<{}} {:>12} {:>12} {:>10} {:>9}\n",
               fit.coefficient_names[k],
               width,
               number(fit.estimate[j]),
               number(errors[j]),
               std::isnan(t[j]) ? "-" : fmt::format("{:.4g}", t[j]),
               p_text(p[j]));
  }
  fmt::print("t and p with {} degrees of freedom\n\n", number(fit.degrees_of_freedom));
}

void print_random_effects(const FittedModel& fit) {
  if (!fit.has_random_effects()) return;
  const std::size_t width = widest(fit.random_names, 13);
  const Eigen::VectorXd deviations = fit.random_sd();
  const Eigen::MatrixXd correlation = fit.random_correlation();
  fmt::print("{:<{}} {:>12}{}\n",
             "random effect",
             width,
             "std. dev.",
             fit.random_names.size() > 1 ? "  correlation" : "");
  for (std::size_t k = 0; k < fit.random_names.size(); ++k) {
    const auto i = static_cast<Index>(k);
    fmt::print("{:<{}} {:>12}", fit.random_names[k], width, number(deviations[i]));
    for (Index j = 0; j < i; ++j) {
      const double value = correlation(i, j);
      fmt::print(" {:>8}", std::isnan(value) ? "-" : fmt::format("{:.4f}", value));
    }
    fmt::print("\n");
  }
  fmt::print("\n");
}

void print_residuals(const FittedModel& fit) {
  fmt::print("sigma {}", number(fit.sigma));
  if (fit.variance.function.kind != Kind::kNone)
    fmt::print(", delta {}", number(fit.variance.delta));
  if (fit.variance.function.kind == Kind::kConstantPlusPower) {
    fmt::print(", constant {}", number(fit.variance.constant));
  }
  fmt::print("\n");
}

void print_statistics(const FittedModel& fit) {
  if (std::isnan(fit.log_likelihood)) return;
  fmt::print("log-likelihood {:.6f} with {} parameters\n", fit.log_likelihood, fit.parameter_count);
  fmt::print("AIC {:.4f}  AICc {:.4f}  BIC {:.4f}\n\n", fit.aic(), fit.aicc(), fit.bic());
  const auto line = [](const char* level, const fit::FitStatistics& values) {
    fmt::print("{:<13} {:>10} {:>10} {:>12} {:>10}\n",
               level,
               fmt::format("{:.4f}", values.r2),
               number(values.rmse),
               fmt::format("{:.3g}", values.mean_error),
               number(values.mae));
  };
  fmt::print(
      "{:<13} {:>10} {:>10} {:>12} {:>10}\n", "prediction", "R2", "RMSE", "mean error", "MAE");
  line("population", fit.population);
  if (fit.has_random_effects()) line("conditional", fit.conditional);
}

void print_failures(const std::vector<const FittedModel*>& failures) {
  if (failures.empty()) return;
  fmt::print("\nwithout a fit\n");
  for (const FittedModel* failure : failures) {
    fmt::print("{:<6} {}\n       {}\n",
               failure->model,
               failure->specification.formula.text,
               failure->convergence.verdict);
  }
}

}  // namespace

void print_fit(const FittedModel& fit) {
  print_model(fit);
  print_fixed_effects(fit);
  print_random_effects(fit);
  print_residuals(fit);
  print_statistics(fit);
}

void print_ranking(const std::vector<const FittedModel*>& fits) {
  std::vector<const FittedModel*> ranked = fits;
  const auto failed =
      std::stable_partition(ranked.begin(), ranked.end(), [](const FittedModel* fit) {
        return fit->convergence.converged;
      });
  const std::vector<const FittedModel*> failures(failed, ranked.end());
  ranked.erase(failed, ranked.end());
  std::ranges::stable_sort(ranked, {}, [](const FittedModel* fit) { return fit->aic(); });

  fmt::print("{:<6} {:>4} {:>13} {:>10} {:>13} {:>8} {:>10}  {}\n",
             "model",
             "k",
             "AIC",
             "difference",
             "BIC",
             "R2",
             "RMSE",
             "formula");
  for (const FittedModel* fit : ranked) {
    const fit::FitStatistics& statistics =
        fit->has_random_effects() ? fit->conditional : fit->population;
    fmt::print("{:<6} {:>4} {:>13.4f} {:>10.4f} {:>13.4f} {:>8.4f} {:>10.5g}  {}\n",
               fit->model,
               fit->parameter_count,
               fit->aic(),
               fit->aic() - ranked.front()->aic(),
               fit->bic(),
               statistics.r2,
               statistics.rmse,
               fit->specification.formula.text);
  }
  print_failures(failures);
}

}  // namespace silvafit::cli
