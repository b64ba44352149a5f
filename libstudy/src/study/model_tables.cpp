// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "silvafit/fit/conditional_errors.hpp"
#include "silvafit/fit/random_effects.hpp"
#include "study/chosen_fits.hpp"
#include "study/outliers.hpp"
#include "study/study_tables.hpp"

namespace silvafit::study {
namespace {

using Names = std::vector<std::string>;

/// A missing number: an empty cell.
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

void add_once(const std::string& name, Names& names) {
  if (std::ranges::find(names, name) == names.end()) names.push_back(name);
}

/// The coefficient b:C as b and C; the coefficient b as b and an empty text.
std::pair<std::string, std::string> parts_of(const std::string& coefficient) {
  const std::size_t colon = coefficient.find(':');
  if (colon == std::string::npos) return {coefficient, ""};
  return {coefficient.substr(0, colon), coefficient.substr(colon + 1)};
}

/// Parameters and covariates of all chosen models in order of first occurrence, each a column.
struct CoefficientColumns {
  Names parameters{};
  Names covariates{};
};

CoefficientColumns columns_of(const Study& study) {
  CoefficientColumns columns;
  for (const ResponseStudy& result : study.results) {
    for (const ChosenFit& chosen : chosen_fits(result)) {
      for (const std::string& name : chosen.fit->coefficient_names) {
        const auto [parameter, covariate] = parts_of(name);
        if (covariate.empty()) add_once(parameter, columns.parameters);
        if (!covariate.empty()) add_once(covariate, columns.covariates);
      }
    }
  }
  std::ranges::sort(columns.parameters);
  return columns;
}

std::string stars(double p) {
  constexpr double kThree = 0.001;
  constexpr double kTwo = 0.01;
  constexpr double kOne = 0.05;
  if (p < kThree) return "***";
  if (p < kTwo) return "**";
  return p < kOne ? "*" : "";
}

const std::map<std::string, std::string>& level_titles() {
  static const std::map<std::string, std::string> titles{
      {"ols", "OLS"}, {"covariates", "OLS, covariates"}, {"nlme", "NLME"}};
  return titles;
}

TableRow model_cells(const ResponseStudy& result, const ChosenFit& chosen) {
  return {result.species, result.response, level_titles().at(chosen.level)};
}

const std::vector<TableColumn> kModelColumns{
    {"species", "Species"}, {"response", "Response"}, {"model", "Model"}};

TableCell estimate_cell(const fit::FittedModel& fit, const std::string& column) {
  const Eigen::VectorXd p = fit.p_values();
  std::vector<MarkedNumber> estimates;
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const auto [parameter, covariate] = parts_of(fit.coefficient_names[k]);
    if (covariate.empty() ? parameter != column : covariate != column) continue;
    const std::string before = covariate.empty() ? "" : parameter + ": ";
    estimates.push_back({before, fit.estimate[at], stars(p[at])});
  }
  if (estimates.empty()) return {};
  if (estimates.size() == 1) return estimates.front();
  // The same covariate on two parameters.
  Names texts;
  for (const MarkedNumber& each : estimates) {
    texts.push_back(shown_text(each, ColumnKind::kEstimate));
  }
  return fmt::format("{}", fmt::join(texts, "; "));
}

/// Variances and correlations by position: those of the first random effect, of the second, ...
void add_component_columns(std::size_t effects, FormattedTable& table) {
  for (std::size_t i = 1; i <= effects; ++i) {
    table.columns.push_back(
        {fmt::format("psi2_{}", i), fmt::format("\u03C8\u00B2({})", i), ColumnKind::kEstimate});
  }
  for (std::size_t i = 2; i <= effects; ++i) {
    for (std::size_t j = 1; j < i; ++j) {
      table.columns.push_back(
          {fmt::format("cor_{}{}", j, i), fmt::format("cor({}, {})", j, i), ColumnKind::kShare});
    }
  }
}

/// A random effect by its position among those of all groupings, the coarser ones first.
struct EffectAtPosition {
  const fit::EstimatedEffects* term = nullptr;
  Eigen::Index at = 0;
  std::string name{};  ///< "a", of two groupings "a | plot"
};

std::vector<EffectAtPosition> random_effects_of(const fit::FittedModel& fit) {
  std::vector<EffectAtPosition> effects;
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    const fit::EstimatedEffects& term = fit.random[k];
    const std::string group = grouping_suffix(fit, k);
    for (std::size_t i = 0; i < term.names.size(); ++i) {
      effects.push_back(
          {.term = &term, .at = static_cast<Eigen::Index>(i), .name = term.names[i] + group});
    }
  }
  return effects;
}

/// The variance of a random effect; zero if it differs from zero by rounding only.
double variance_of(const fit::FittedModel& fit, const EffectAtPosition& effect) {
  const std::string zero = fmt::format("sd({}) = 0", effect.name);
  const Names& boundary = fit.convergence.boundary();
  const bool is_zero = std::ranges::find(boundary, zero) != boundary.end();
  return is_zero ? 0.0 : effect.term->covariance(effect.at, effect.at);
}

void add_components(const fit::FittedModel& fit, std::size_t effects, TableRow& row) {
  const std::vector<EffectAtPosition> own = random_effects_of(fit);
  for (std::size_t i = 0; i < effects; ++i) {
    row.emplace_back(i < own.size() ? variance_of(fit, own[i]) : kNoValue);
  }
  for (std::size_t i = 1; i < effects; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool have_correlation = i < own.size() && own[i].term == own[j].term;
      row.emplace_back(have_correlation ? own[i].term->correlation()(own[i].at, own[j].at)
                                        : kNoValue);
    }
  }
}

/// "power, 0.54"; "none".
std::string variance_text(const fit::FittedModel& fit) {
  const fit::VarianceFunction function = fit.variance.function();
  const int parameters = fit.variance.function().parameter_count();
  std::string text = function.text();
  if (parameters > 0) {
    text += ", " + shown_text(MarkedNumber{.value = fit.variance.delta()}, ColumnKind::kEstimate);
  }
  if (parameters > 1) {
    text +=
        ", " + shown_text(MarkedNumber{.value = fit.variance.constant()}, ColumnKind::kEstimate);
  }
  return text;
}

/// R2 and RMSE of a level for plots left out.
TableRow left_out_cells(const ResponseStudy& result, const std::string& level) {
  if (!result.left_out) return {kNoValue, kNoValue};
  const LeftOutPlots& left_out = *result.left_out;
  if (level == "ols") return {left_out.r2_ols, left_out.rmse_ols};
  if (level == "covariates") return {left_out.r2_covariates, left_out.rmse_covariates};
  return {left_out.r2_nlme, left_out.rmse_nlme};
}

std::size_t most_random_effects(const Study& study) {
  std::size_t most = 0;
  for (const ResponseStudy& result : study.results) {
    if (result.nlme) most = std::max(most, random_effects_of(result.nlme->fit).size());
  }
  return most;
}

/// The rows of one grouping, plots or periods. Only the plots are compared with each other.
void add_plot_effects(const ResponseStudy& result, std::size_t grouping, FormattedTable& table) {
  const fit::FittedModel& fit = result.nlme->fit;
  const fit::EstimatedEffects& term = fit.random[grouping];
  const std::vector<PlotDistance> distances =
      grouping == 0 ? plot_distances(fit) : std::vector<PlotDistance>(term.labels.size());
  const auto q = static_cast<Eigen::Index>(term.names.size());
  const bool is_known = term.uncertainty.is_known();
  const Eigen::MatrixXd errors =
      is_known ? fit::conditional_errors(term.uncertainty, q) : Eigen::MatrixXd();
  std::map<std::string, std::string, std::less<>> coarser;
  for (const std::string& label : fit.random.front().labels) {
    coarser.emplace(fit::outer_part(label), label);
  }
  for (std::size_t plot = 0; plot < term.labels.size(); ++plot) {
    const std::string& label = term.labels[plot];
    for (Eigen::Index effect = 0; effect < q; ++effect) {
      const auto column = static_cast<Eigen::Index>(plot);
      TableRow row{result.species, result.response};
      if (grouping == 0) {
        row.emplace_back(label);
        if (!result.period.empty()) row.emplace_back(std::string());
      } else {
        const fit::NestedParts parts = fit::nested_parts(label);
        row.insert(row.end(), {coarser.find(parts.outer)->second, std::string(parts.inner)});
      }
      row.insert(row.end(),
                 {term.names[static_cast<std::size_t>(effect)],
                  term.effects(effect, column),
                  is_known ? errors(effect, column) : kNoValue,
                  distances[plot].distance,
                  distances[plot].p});
      table.rows.push_back(std::move(row));
    }
  }
}

}  // namespace

FormattedTable coefficients_table(const Study& study) {
  const CoefficientColumns names = columns_of(study);
  FormattedTable table{
      .name = "coefficients",
      .caption =
          "Coefficients of the chosen models. *, ** and ***: p below 0.05, 0.01 and 0.001. "
          "Models of one species and response that share a letter do not differ; stars "
          "after the letters are those of the likelihood-ratio test against the model above",
      .columns = kModelColumns};
  for (const Names& columns : {names.parameters, names.covariates}) {
    for (const std::string& name : columns) {
      table.columns.push_back({name, name, ColumnKind::kEstimate});
    }
  }
  table.columns.push_back({"aic", "AIC", ColumnKind::kCriterion});
  table.columns.push_back({"log_likelihood", "Log-likelihood", ColumnKind::kCriterion});
  table.columns.push_back({"letters", "Letters"});
  for (const ResponseStudy& result : study.results) {
    const std::vector<ChosenFit> fits = distinct_fits(result);
    const std::vector<std::string> letters = letters_of(fits, study.options);
    for (std::size_t i = 0; i < fits.size(); ++i) {
      TableRow row = model_cells(result, fits[i]);
      for (const Names& columns : {names.parameters, names.covariates}) {
        for (const std::string& name : columns) row.push_back(estimate_cell(*fits[i].fit, name));
      }
      const auto test = test_against_before(fits, i);
      const std::string mark = test ? stars(test->p) : "";
      row.insert(row.end(),
                 {fits[i].fit->aic(),
                  fits[i].fit->log_likelihood,
                  letters[i] + (mark.empty() ? "" : " " + mark)});
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

FormattedTable variance_and_fit_table(const Study& study) {
  const std::size_t effects = most_random_effects(study);
  FormattedTable table{
      .name = "variance_and_fit",
      .caption =
          "Variance components and accuracy of the chosen models. Random effects are on the "
          "coefficients named, in that order; accuracy is that of the conditional "
          "prediction for NLME; left out: predictions for plots left out of the fit, with "
          "random effects zero",
      .columns = kModelColumns};
  table.columns.push_back({"random_effects", "Random effects"});
  table.columns.push_back({"sigma2", "\u03C3\u00B2", ColumnKind::kEstimate});
  add_component_columns(effects, table);
  const std::vector<TableColumn> accuracy{{"variance_function", "Variance function"},
                                          {"r2", "R\u00B2", ColumnKind::kShare},
                                          {"mean_error", "Mean error", ColumnKind::kShare},
                                          {"rmse", "RMSE", ColumnKind::kShare},
                                          {"r2_left_out", "R\u00B2, left out", ColumnKind::kShare},
                                          {"rmse_left_out", "RMSE, left out", ColumnKind::kShare}};
  table.columns.insert(table.columns.end(), accuracy.begin(), accuracy.end());
  for (const ResponseStudy& result : study.results) {
    for (const ChosenFit& chosen : distinct_fits(result)) {
      const fit::FittedModel& fit = *chosen.fit;
      TableRow row = model_cells(result, chosen);
      Names names;
      for (const EffectAtPosition& effect : random_effects_of(fit)) names.push_back(effect.name);
      row.emplace_back(fmt::format("{}", fmt::join(names, ", ")));
      row.emplace_back(fit.sigma * fit.sigma);
      add_components(fit, effects, row);
      const fit::FitStatistics& values =
          fit.has_random_effects() ? fit.conditional : fit.population;
      row.insert(row.end(), {variance_text(fit), values.r2, values.mean_error, values.rmse});
      const TableRow left_out = left_out_cells(result, chosen.level);
      row.insert(row.end(), left_out.begin(), left_out.end());
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

FormattedTable plot_effects_table(const Study& study) {
  const StudyOptions& options = study.options;
  FormattedTable table{
      .name = "plot_effects",
      .caption =
          "Random effects of each plot: EBLUP, its conditional standard error, and the "
          "distance of the plot from the others with its p-value (Bonferroni)",
      .columns = {{"species", "Species"},
                  {"response", "Response"},
                  {options.group, options.group == "plot" ? "Plot" : options.group}}};
  if (!options.period.empty()) table.columns.push_back({options.period, options.period});
  const std::vector<TableColumn> values{{"effect", "Random effect on"},
                                        {"eblup", "EBLUP", ColumnKind::kEstimate},
                                        {"se", "Standard error", ColumnKind::kEstimate},
                                        {"distance", "Distance", ColumnKind::kCriterion},
                                        {"p", "p", ColumnKind::kP}};
  table.columns.insert(table.columns.end(), values.begin(), values.end());
  for (const ResponseStudy& result : study.results) {
    for (std::size_t k = 0; result.nlme && k < result.nlme->fit.random.size(); ++k) {
      const bool is_of_trees = result.nlme->fit.specification.random[k].group == kTree;
      if (!is_of_trees) add_plot_effects(result, k, table);
    }
  }
  return table;
}

}  // namespace silvafit::study
