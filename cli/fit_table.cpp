// SPDX-License-Identifier: MIT
#include "fit_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "number_text.hpp"
#include "silvafit/base/text.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

using Eigen::Index;
using fit::FittedModel;

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

/// \param groups  "plot", or "plot within stand"
void print_random_structure(const fit::RandomEffects& random, const std::string& groups) {
  print_text("  random: {} | {}, {} covariance\n",
             random.text(),
             groups,
             fit::covariance_text(random.covariance));
}

/// The coarser groups first, as --random has them.
void print_random_structures(const fit::ModelSpecification& specification) {
  std::string within;
  for (const fit::RandomEffects& term : specification.random) {
    print_random_structure(term, term.group + within);
    within = " within " + term.group;
  }
}

/// "1 plot group", "7 plot groups".
std::string groups_text(std::size_t count, const std::string& column) {
  return counted(count, column + " group", column + " groups");
}

void print_model(const FittedModel& fit) {
  const fit::ModelSpecification& specification = fit.specification;
  print_text("{}{}\n", fit.model.empty() ? "" : fit.model + "  ", specification.formula.text);
  for (const fit::ParameterModel& parameter : specification.parameters) {
    if (parameter.text() != "1") print_text("  {} ~ {}\n", parameter.name, parameter.text());
  }
  print_random_structures(specification);
  if (!specification.variance.is_constant()) {
    print_text("  variance: {}\n", specification.variance.text());
  }
  print_text("{}\n\n", fit.convergence.verdict);
  print_text("method {}, {} rows", fit::method_text(fit.method), fit.observations);
  if (fit.excluded > 0) print_text(" ({} more with missing values)", fit.excluded);
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    print_text(", {}", groups_text(fit.random[k].labels.size(), specification.random[k].group));
  }
  print_text(", {:.3g} s\n\n", fit.seconds);
}

void print_fixed_effects(const FittedModel& fit) {
  const std::size_t width = widest(fit.coefficient_names, 13);
  const Eigen::VectorXd errors = fit.standard_errors();
  const Eigen::VectorXd t = fit.t_values();
  const Eigen::VectorXd p = fit.p_values();
  print_text("{:<{}} {:>12} {:>12} {:>8} {:>10} {:>9}\n",
             "coefficient",
             width,
             "estimate",
             "std. error",
             "df",
             "t",
             "p");
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    const auto j = static_cast<Index>(k);
    print_text("{:<{}} {:>12} {:>12} {:>8} {:>10} {:>9}\n",
               fit.coefficient_names[k],
               width,
               significant(fit.estimate[j]),
               significant(errors[j]),
               significant(j < fit.degrees_of_freedom.size() ? fit.degrees_of_freedom[j] : NAN),
               significant(t[j], 4),
               p_text(p[j]));
  }
  print_text("\n");
}

/// For each effect the block that it is in; effects of different blocks have no correlation.
std::vector<std::size_t> blocks_of(const fit::RandomEffects& random, std::size_t effects) {
  std::vector<std::size_t> blocks;
  const std::vector<int> sizes = random.block_sizes();
  for (std::size_t block = 0; block < sizes.size(); ++block) {
    blocks.insert(blocks.end(), static_cast<std::size_t>(sizes[block]), block);
  }
  blocks.resize(effects, sizes.size());
  return blocks;
}

/// \param title  of the first column
void print_random_level(const std::string& title,
                        const fit::RandomEffects& random,
                        const fit::EstimatedEffects& term) {
  const std::vector<std::string>& names = term.names;
  const std::vector<std::size_t> block = blocks_of(random, names.size());
  const bool has_correlation = std::ranges::adjacent_find(block) != block.end();
  const std::size_t width = widest(names, std::max<std::size_t>(13, title.size()));
  const Eigen::VectorXd deviations = term.sd();
  const Eigen::MatrixXd correlation = term.correlation();
  print_text(
      "{:<{}} {:>12}{}\n", title, width, "std. dev.", has_correlation ? "  correlation" : "");
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto i = static_cast<Index>(k);
    print_text("{:<{}} {:>12}", names[k], width, significant(deviations[i]));
    for (std::size_t l = 0; has_correlation && l < k; ++l) {
      const double value = block[l] == block[k] ? correlation(i, static_cast<Index>(l)) : NAN;
      print_text(" {:>8}", decimals(value));
    }
    print_text("\n");
  }
  print_text("\n");
}

void print_random_effects(const FittedModel& fit) {
  const std::vector<fit::RandomEffects>& terms = fit.specification.random;
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    const std::string of = terms.size() > 1 ? " of " + terms[k].group : "";
    print_random_level("random effect" + of, terms[k], fit.random[k]);
  }
}

void print_variance_factor(const fit::VarianceFactorEstimate& estimate) {
  const auto print_values = [&](const char* name, const Eigen::VectorXd& values) {
    for (Index s = 0; s < values.size(); ++s) {
      const std::string& stratum = estimate.strata[static_cast<std::size_t>(s)];
      print_text(", {}{}{} {}",
                 name,
                 stratum.empty() ? "" : " of ",
                 stratum,
                 std::isinf(values[s]) ? "infinite" : significant(values[s]));
    }
  };
  print_values("delta", estimate.delta);
  print_values("constant", estimate.constant);
  print_values("ratio", estimate.ratio);
}

void print_residuals(const FittedModel& fit) {
  print_text("sigma {}", significant(fit.sigma));
  for (const fit::VarianceFactorEstimate& factor : fit.variance.factors) {
    print_variance_factor(factor);
  }
  print_text("\n");
}

void print_statistics(const FittedModel& fit) {
  if (std::isnan(fit.log_likelihood)) return;
  print_text("log-likelihood {:.6f} with {} parameters\n", fit.log_likelihood, fit.parameter_count);
  print_text("AIC {:.4f}  AICc {:.4f}  BIC {:.4f}", fit.aic(), fit.aicc(), fit.bic());
  if (fit.has_random_effects()) print_text("  BIC by groups {:.4f}", fit.bic_groups());
  print_text("\n\n");
  const auto line = [](const char* level, const fit::FitStatistics& values) {
    print_text("{:<13} {:>10} {:>10} {:>12} {:>10}\n",
               level,
               decimals(values.r2),
               significant(values.rmse),
               significant(values.mean_error, 3),
               significant(values.mae));
  };
  print_text(
      "{:<13} {:>10} {:>10} {:>12} {:>10}\n", "prediction", "R2", "RMSE", "mean error", "MAE");
  line("population", fit.population);
  if (!fit.has_random_effects()) return;
  line("conditional", fit.conditional);
  print_text(
      "variance explained: {} by fixed effects (marginal R2), {} with random effects "
      "(conditional R2)\n",
      decimals(fit.r2_marginal),
      decimals(fit.r2_conditional));
}

void print_failures(const std::vector<const FittedModel*>& failures) {
  if (failures.empty()) return;
  print_text("\nmodels without a fit\n");
  for (const FittedModel* failure : failures) {
    print_text("{:<6} {}\n       {}\n",
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
        return fit->convergence.converged();
      });
  const std::vector<const FittedModel*> failures(failed, ranked.end());
  ranked.erase(failed, ranked.end());
  std::ranges::stable_sort(ranked, {}, [](const FittedModel* fit) { return fit->aic(); });

  print_text("{:<6} {:>4} {:>13} {:>10} {:>13} {:>8} {:>10}  {}\n",
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
    print_text("{:<6} {:>4} {:>13.4f} {:>10.4f} {:>13.4f} {:>8} {:>10.5g}  {}\n",
               fit->model,
               fit->parameter_count,
               fit->aic(),
               fit->aic() - ranked.front()->aic(),
               fit->bic(),
               decimals(statistics.r2),
               statistics.rmse,
               fit->specification.formula.text);
  }
  print_failures(failures);
}

}  // namespace silvafit::cli
