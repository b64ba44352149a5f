// SPDX-License-Identifier: MIT
#include "silvafit/fit/summary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "silvafit/base/text.hpp"
#include "silvafit/fit/conditional_errors.hpp"
#include "silvafit/fit/intervals.hpp"
#include "silvafit/fit/term_tests.hpp"
#include "summary/text_lines.hpp"

namespace silvafit::fit {
namespace {

/// Below the smallest difference of doubles near 1, p-values are noise.
std::string p_text(double value) {
  constexpr double kNoise = 2e-16;
  if (std::isnan(value)) return "-";
  return value < kNoise ? "< 2e-16" : fmt::format("{:.3g}", value);
}

/// \param groups  "plot", or "plot within stand"
void append_random_structure(std::string& text,
                             const RandomEffects& random,
                             const std::string& groups) {
  append(text,
         "  random: {} | {}, {} covariance\n",
         random.text(),
         groups,
         word_of(random.covariance));
}

/// The coarser groups first, as in --random; "year, crossed" where groups are not within others.
void append_random_structures(std::string& text, const ModelSpecification& specification) {
  std::string within;
  for (const RandomEffects& term : specification.random) {
    if (term.is_crossed) {
      const bool is_first = &term == &specification.random.front();
      within = term.within.empty() && !is_first ? ", crossed" : "";
      for (auto column = term.within.rbegin(); column != term.within.rend(); ++column) {
        within += " within " + *column;
      }
    }
    append_random_structure(text, term, term.group + within);
    within = " within " + term.group;
  }
}

/// "1 plot group", "7 plot groups".
std::string groups_text(std::size_t count, const std::string& column) {
  return counted(count, column + " group", column + " groups");
}

/// "lb (Lindstrom and Bates, as nlme) by REML".
std::string method_title(const FittedModel& fit) {
  const char* const likelihood = fit.reml ? " by REML" : " by ML";
  const auto title = [&](const char* name, const char* by) {
    return fmt::format("{} ({}){}", word_of(fit.method), name, by);
  };
  switch (fit.method) {
    case Method::kOrdinary:
      return title("least squares", "");
    case Method::kGeneralized:
      return title("generalized least squares, as nlme's gnls", likelihood);
    case Method::kLindstromBates:
      return title("Lindstrom and Bates, as nlme", likelihood);
    case Method::kFirstOrder:
      return title("first-order conditional estimation", likelihood);
    case Method::kInteraction:
      return title("first-order conditional estimation with interaction", likelihood);
    case Method::kLaplace:
      return title("Laplace's approximation", likelihood);
    case Method::kQuadrature:
      return title("adaptive Gauss-Hermite quadrature", likelihood);
  }
  return word_of(fit.method);
}

void append_model(std::string& text, const FittedModel& fit) {
  const ModelSpecification& specification = fit.specification;
  append(text, "{}{}\n", fit.model.empty() ? "" : fit.model + "  ", specification.formula.text);
  for (const ParameterModel& parameter : specification.parameters) {
    if (parameter.text() != "1") append(text, "  {} ~ {}\n", parameter.name, parameter.text());
  }
  append_random_structures(text, specification);
  if (!specification.variance.is_constant()) {
    append(text, "  variance: {}\n", specification.variance.text());
  }
  if (const auto& correlation = specification.correlation) {
    const bool is_by_order =
        correlation->columns.empty() && correlation->kind != Correlation::Kind::kCompoundSymmetry;
    const bool is_one_group = correlation->group.empty() && specification.random.empty();
    append(text,
           "  correlation of the residuals: {}{}{}\n",
           correlation->text(),
           is_by_order ? ", in the order of the rows" : "",
           is_one_group ? ", all rows as one group" : "");
  }
  append(text, "{}\n\n", fit.convergence.verdict());
  append(text, "method {}, {} rows", method_title(fit), fit.observations);
  if (fit.excluded > 0) append(text, " ({} more with missing values)", fit.excluded);
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    append(text,
           ", {}",
           groups_text(fit.random[k].labels.size(), specification.random[k].group_name()));
  }
  append(text, ", {:.3g} s\n\n", fit.seconds);
}

/// Where a search ended without a maximum: tests, criteria and effects of groups do not hold there.
void append_unconverged(std::string& text, const FittedModel& fit) {
  append(text, "NOT CONVERGED: the values where the search ended, without tests and criteria\n\n");
  TextTable table(13, {12});
  table.add({"coefficient", "value"});
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    table.add({fit.coefficient_names[k], significant(fit.estimate[static_cast<Index>(k)])});
  }
  table.append_to(text);
  text += '\n';
}

void append_fixed_effects(std::string& text, const FittedModel& fit) {
  const VectorXd errors = fit.standard_errors();
  const VectorXd t = fit.t_values();
  const VectorXd p = fit.p_values();
  TextTable table(13, {12, 12, 8, 10, 9});
  table.add({"coefficient", "estimate", "std. error", "df", "Wald t", "p"});
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    const auto j = static_cast<Index>(k);
    const bool has_freedom = j < fit.degrees_of_freedom.size();
    table.add({fit.coefficient_names[k],
               significant(fit.estimate[j]),
               significant(errors[j]),
               significant(has_freedom ? fit.degrees_of_freedom[j] : NAN),
               significant(t[j], 4),
               p_text(p[j])});
  }
  table.append_to(text);
  text += '\n';
}

/// The block of each effect; effects of different blocks have no correlation.
std::vector<std::size_t> blocks_of(const RandomEffects& random, std::size_t effects) {
  std::vector<std::size_t> blocks;
  const std::vector<int> sizes = random.block_sizes();
  for (std::size_t block = 0; block < sizes.size(); ++block) {
    blocks.insert(blocks.end(), static_cast<std::size_t>(sizes[block]), block);
  }
  blocks.resize(effects, sizes.size());
  return blocks;
}

/// \param title  of the first column
void append_random_level(std::string& text,
                         const std::string& title,
                         const RandomEffects& random,
                         const EstimatedEffects& term) {
  const std::vector<std::string>& names = term.names;
  const std::vector<std::size_t> block = blocks_of(random, names.size());
  const bool has_correlation = std::ranges::adjacent_find(block) != block.end();
  const VectorXd deviations = term.sd();
  const MatrixXd correlation = term.correlation();
  std::vector<int> widths(names.size(), 8);
  widths.front() = 12;
  TextTable table(13, std::move(widths));
  std::vector<std::string> titles{title, "std. dev."};
  if (has_correlation) titles.emplace_back(" correlation");
  table.add(std::move(titles));
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto i = static_cast<Index>(k);
    std::vector<std::string> cells{names[k], significant(deviations[i])};
    for (std::size_t l = 0; has_correlation && l < k; ++l) {
      cells.push_back(decimals(block[l] == block[k] ? correlation(i, static_cast<Index>(l)) : NAN));
    }
    table.add(std::move(cells));
  }
  table.append_to(text);
  text += '\n';
}

void append_derived(std::string& text, const FittedModel& fit) {
  if (fit.specification.derived.empty()) return;
  TextTable table(16, {12, 12, 8});
  table.add({"derived quantity", "estimate", "std. error", "df"});
  const std::vector<DerivedValue> values = derived_values(fit);
  for (std::size_t k = 0; k < values.size(); ++k) {
    table.add({fit.specification.derived[k].name,
               significant(values[k].estimate),
               significant(values[k].standard_error),
               significant(values[k].degrees_of_freedom)});
  }
  table.append_to(text);
  text += '\n';
}

/// Of terms with several coefficients, which the tests of single ones do not answer.
void append_term_tests(std::string& text, const FittedModel& fit) {
  TextTable table(16, {12, 12, 10, 9});
  table.add({"term", "num. df", "den. df", "Wald F", "p"});
  bool has_terms = false;
  for (const TermTest& test : term_tests(fit)) {
    if (test.numerator_df < 2) continue;
    has_terms = true;
    table.add({test.term,
               significant(test.numerator_df),
               significant(test.denominator_df),
               significant(test.f, 4),
               p_text(test.p)});
  }
  if (!has_terms) return;
  table.append_to(text);
  text += '\n';
}

void append_random_effects(std::string& text, const FittedModel& fit) {
  const std::vector<RandomEffects>& terms = fit.specification.random;
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    const std::string of = terms.size() > 1 ? " of " + terms[k].group_name() : "";
    append_random_level(text, "random effect" + of, terms[k], fit.random[k]);
  }
}

/// Ratios to the first stratum also as standard deviations, as nlme's users know them from sigma.
void append_variance_factor(std::string& text,
                            const VarianceFactorEstimate& estimate,
                            double sigma) {
  const auto append_values = [&](const char* name, const VectorXd& values) {
    for (Index s = 0; s < values.size(); ++s) {
      const std::string& stratum = estimate.strata[static_cast<std::size_t>(s)];
      append(text,
             ", {}{}{} {}",
             name,
             stratum.empty() ? "" : " of ",
             stratum,
             std::isinf(values[s]) ? "infinite" : significant(values[s]));
    }
  };
  append_values("delta", estimate.delta);
  append_values("constant", estimate.constant);
  append_values("ratio", estimate.ratio);
  append_values("sd", sigma * estimate.ratio);
}

void append_residuals(std::string& text, const FittedModel& fit) {
  append(text, "sigma {}", significant(fit.sigma));
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    append_variance_factor(text, factor, fit.sigma);
  }
  if (const auto& correlation = fit.variance.correlation) {
    for (std::size_t k = 0; k < correlation->names.size(); ++k) {
      append(text,
             ", {} {}",
             correlation->names[k],
             significant(correlation->values[static_cast<Index>(k)]));
    }
  }
  append(text, "\n");
}

void append_statistics(std::string& text, const FittedModel& fit) {
  if (std::isnan(fit.log_likelihood)) return;
  append(
      text, "log-likelihood {:.6f} with {} parameters\n", fit.log_likelihood, fit.parameter_count);
  append(text, "AIC {:.4f}  AICc {:.4f}  BIC {:.4f}", fit.aic(), fit.aicc(), fit.bic());
  if (const double value = fit.bic_groups(); fit.has_random_effects() && !std::isnan(value)) {
    append(text, "  BIC by groups {:.4f}", value);
  }
  append(text, "\n\n");
  TextTable table(13, {10, 10, 12, 10});
  table.add({"prediction", "R2", "RMSE", "mean error", "MAE"});
  table.add(statistics_cells("population", fit.population));
  if (fit.has_random_effects()) table.add(statistics_cells("conditional", fit.conditional));
  table.append_to(text);
  if (!fit.has_random_effects()) return;
  append(text,
         "variance explained: {} by fixed effects (marginal R2), {} with random effects "
         "(conditional R2)\n",
         decimals(fit.r2_marginal),
         decimals(fit.r2_conditional));
}

std::string limit_text(double value) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0.0 ? "unbounded" : "-unbounded";
  return fmt::format("{:.6g}", value);
}

/// Maximum number of printed groups; `--json` lists all.
constexpr std::size_t kMostGroups = 40;

void append_effects(std::string& text, const std::string& group, const EstimatedEffects& term) {
  if (!term.uncertainty.is_known() || term.labels.size() > kMostGroups) return;
  const MatrixXd errors = conditional_errors(term.uncertainty, term.effects.rows());
  std::vector<std::string> titles{group};
  for (const std::string& name : term.names) {
    titles.push_back(name);
    titles.emplace_back("std. error");
  }
  TextTable table(13, std::vector<int>(titles.size(), 12));
  table.add(std::move(titles));
  for (std::size_t g = 0; g < term.labels.size(); ++g) {
    std::vector<std::string> cells{term.labels[g]};
    for (Index k = 0; k < term.effects.rows(); ++k) {
      const auto at = static_cast<Index>(g);
      cells.push_back(fmt::format("{:.5g}", term.effects(k, at)));
      cells.push_back(fmt::format("{:.5g}", errors(k, at)));
    }
    table.add(std::move(cells));
  }
  text += '\n';
  table.append_to(text);
}

void append_all_effects(std::string& text, const FittedModel& fit) {
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    append_effects(text, fit.specification.random[k].group, fit.random[k]);
  }
}

void append_inference(std::string& text, const FittedModel& fit) {
  append_all_effects(text, fit);
  if (!fit.intervals) return;
  const Intervals& intervals = *fit.intervals;
  append(text,
         "\n{:g} % intervals, {}, {}\n",
         100.0 * intervals.level,
         intervals.method == IntervalMethod::kWald ? "Wald" : "profile",
         intervals.likelihood);
  TextTable table(13, {12, 12, 12, 0});
  table.add({"parameter", "estimate", "lower", "upper"});
  for (const ParameterInterval& one : intervals.parameters) {
    table.add({one.name,
               limit_text(one.estimate),
               limit_text(one.lower),
               limit_text(one.upper),
               one.note});
  }
  table.append_to(text);
}

void append_failures(std::string& text, const std::vector<const FittedModel*>& failures) {
  if (failures.empty()) return;
  append(text, "\nmodels without a fit\n");
  for (const FittedModel* failure : failures) {
    append(text,
           "{:<6} {}\n       {}\n",
           failure->model,
           failure->specification.formula.text,
           failure->convergence.verdict());
  }
}

}  // namespace

std::string summary(const FittedModel& fit) {
  std::string text;
  append_model(text, fit);
  if (!fit.convergence.converged()) {
    append_unconverged(text, fit);
    append_random_effects(text, fit);
    append_residuals(text, fit);
    return text;
  }
  append_fixed_effects(text, fit);
  append_term_tests(text, fit);
  append_derived(text, fit);
  append_random_effects(text, fit);
  append_residuals(text, fit);
  append_statistics(text, fit);
  append_inference(text, fit);
  return text;
}

std::string ranking(const std::vector<const FittedModel*>& fits) {
  std::string text;
  std::vector<const FittedModel*> ranked = fits;
  const auto failed =
      std::stable_partition(ranked.begin(), ranked.end(), [](const FittedModel* fit) {
        return fit->convergence.converged();
      });
  const std::vector<const FittedModel*> failures(failed, ranked.end());
  ranked.erase(failed, ranked.end());
  std::ranges::stable_sort(ranked, {}, [](const FittedModel* fit) { return fit->aic(); });

  TextTable table(6, {4, 13, 10, 13, 8, 10, 0});
  table.add({"model", "k", "AIC", "difference", "BIC", "R2", "RMSE", "formula"});
  for (const FittedModel* fit : ranked) {
    const FitStatistics& statistics =
        fit->has_random_effects() ? fit->conditional : fit->population;
    table.add({fit->model,
               fmt::to_string(fit->parameter_count),
               fmt::format("{:.4f}", fit->aic()),
               fmt::format("{:.4f}", fit->aic() - ranked.front()->aic()),
               fmt::format("{:.4f}", fit->bic()),
               decimals(statistics.r2),
               fmt::format("{:.5g}", statistics.rmse),
               fit->specification.formula.text});
  }
  table.append_to(text);
  append_failures(text, failures);
  return text;
}

}  // namespace silvafit::fit
