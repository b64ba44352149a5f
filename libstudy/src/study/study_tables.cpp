// SPDX-License-Identifier: MIT
#include "study/study_tables.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "study/chosen_fits.hpp"
#include "study/nested_tests.hpp"

namespace silvafit::study {
namespace {

using Columns = std::vector<TableColumn>;

template <typename List>
List joined(List first, const List& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

TableCell number(double value) { return value; }
TableCell count(std::size_t value) { return static_cast<double>(value); }
TableCell rank_cell(int rank) {
  return rank > 0 ? TableCell(static_cast<double>(rank)) : TableCell();
}
TableCell yes_or_no(bool value) { return std::string(value ? "yes" : "no"); }

const Columns kSubject{{"species", "Species"}, {"response", "Response"}};

TableRow subject(const ResponseStudy& result) { return {result.species, result.response}; }

const Columns kCriteria{{"k", "k", ColumnKind::kCount},
                        {"log_likelihood", "Log-likelihood", ColumnKind::kCriterion},
                        {"aic", "AIC", ColumnKind::kCriterion},
                        {"bic", "BIC", ColumnKind::kCriterion},
                        {"cv_rmse", "RMSE, left out", ColumnKind::kShare},
                        {"cv_failed_folds", "Failed folds", ColumnKind::kCount},
                        {"rank", "Rank", ColumnKind::kCount},
                        {"chosen", "Chosen"},
                        {"converged", "Converged"},
                        {"verdict", "Verdict"},
                        {"objection", "Objection"}};

TableRow criteria(const Candidate& candidate) {
  const fit::FittedModel& fit = candidate.fit;
  const auto& validated = candidate.cross_validated;
  return {number(fit.parameter_count),
          fit.log_likelihood,
          fit.aic(),
          fit.bic(),
          validated ? number(validated->rmse) : TableCell(),
          validated ? count(validated->failed) : TableCell(),
          rank_cell(candidate.rank),
          yes_or_no(candidate.chosen),
          yes_or_no(fit.convergence.converged()),
          fit.convergence.verdict(),
          candidate.objection};
}

const Columns kStatistics{{"r2", "R\u00B2", ColumnKind::kShare},
                          {"mean_error", "Mean error", ColumnKind::kShare},
                          {"rmse", "RMSE", ColumnKind::kShare},
                          {"mae", "MAE", ColumnKind::kShare}};

TableRow statistics(const fit::FitStatistics& values) {
  return {values.r2, values.mean_error, values.rmse, values.mae};
}

const Columns kTest{{"likelihood_ratio", "Likelihood ratio", ColumnKind::kCriterion},
                    {"df", "df", ColumnKind::kCount},
                    {"p", "p", ColumnKind::kP}};

TableRow test_cells(const std::optional<fit::NestedTest>& test) {
  if (!test) return {TableCell(), TableCell(), TableCell()};
  return {test->statistic, number(test->degrees_of_freedom), test->p};
}

std::string joined_terms(const Candidate& candidate, const char* joint) {
  return fmt::format("{}", fmt::join(candidate.terms, joint));
}

FormattedTable candidates_table(const Study& study, const Catalogue& catalogue) {
  FormattedTable table{
      .name = "candidates",
      .caption = "Level 1: base models by least squares",
      .columns = joined(
          joined(joined(kSubject, {{"model", "Model"}, {"name", "Name"}, {"formula", "Formula"}}),
                 kStatistics),
          kCriteria)};
  for (const ResponseStudy& result : study.results) {
    for (const Candidate& candidate : result.base) {
      const std::string& id = candidate.fit.model;
      const std::string name = id.empty() ? std::string() : catalogue.find(id).name;
      const std::string& formula = candidate.fit.specification.formula.text;
      table.rows.push_back(
          joined(joined(joined(subject(result), {id.empty() ? "own" : id, name, formula}),
                        statistics(candidate.fit.population)),
                 criteria(candidate)));
    }
  }
  return table;
}

FormattedTable covariates_table(const Study& study) {
  FormattedTable table{
      .name = "covariates",
      .caption = "Level 2: covariates on parameters of the base model",
      .columns = joined(
          joined(joined(joined(kSubject, {{"sub_models", "Sub-models"}}), kStatistics), kTest),
          kCriteria)};
  for (const ResponseStudy& result : study.results) {
    for (const Candidate& candidate : result.covariates) {
      table.rows.push_back(
          joined(joined(joined(joined(subject(result), {joined_terms(candidate, "; ")}),
                               statistics(candidate.fit.population)),
                        test_cells(candidate.test)),
                 criteria(candidate)));
    }
  }
  return table;
}

FormattedTable random_effects_table(const Study& study) {
  FormattedTable table{
      .name = "random_effects",
      .caption = "Level 3: random effects, tested against none",
      .columns = joined(
          joined(joined(kSubject,
                        {{"random_effects", "Random effects"}, {"covariance", "Covariance"}}),
                 kTest),
          kCriteria)};
  for (const ResponseStudy& result : study.results) {
    for (const Candidate& candidate : result.random) {
      const fit::Covariance form = candidate.fit.specification.random.back().covariance;
      table.rows.push_back(joined(
          joined(
              joined(subject(result), {name_of(candidate, &ResponseStudy::random), word_of(form)}),
              test_cells(candidate.test)),
          criteria(candidate)));
    }
  }
  return table;
}

FormattedTable variance_functions_table(const Study& study) {
  FormattedTable table{
      .name = "variance_functions",
      .caption = "Level 3: variance functions",
      .columns = joined(joined(joined(kSubject,
                                      {{"function", "Function"},
                                       {"delta", "delta", ColumnKind::kEstimate},
                                       {"constant", "constant", ColumnKind::kEstimate}}),
                               kTest),
                        kCriteria)};
  for (const ResponseStudy& result : study.results) {
    for (const Candidate& candidate : result.variance) {
      const fit::VarianceEstimate& variance = candidate.fit.variance;
      const fit::VarianceFunction function = variance.function();
      table.rows.push_back(joined(
          joined(joined(subject(result), {function.text(), variance.delta(), variance.constant()}),
                 test_cells(candidate.test)),
          criteria(candidate)));
    }
  }
  return table;
}

FormattedTable estimates_table(const Study& study) {
  FormattedTable table{.name = "estimates",
                       .caption = "Coefficients of the chosen models",
                       .columns = joined(kSubject,
                                         {{"level", "Level"},
                                          {"coefficient", "Coefficient"},
                                          {"estimate", "Estimate", ColumnKind::kEstimate},
                                          {"se", "Standard error", ColumnKind::kEstimate},
                                          {"df", "df", ColumnKind::kCount},
                                          {"t", "t", ColumnKind::kCriterion},
                                          {"p", "p", ColumnKind::kP}})};
  for (const ResponseStudy& result : study.results) {
    for (const auto& [level, fit] : chosen_fits(result)) {
      const Eigen::VectorXd errors = fit->standard_errors();
      const Eigen::VectorXd t = fit->t_values();
      const Eigen::VectorXd p = fit->p_values();
      for (Eigen::Index k = 0; k < fit->estimate.size(); ++k) {
        table.rows.push_back(
            joined(subject(result),
                   {level,
                    fit->coefficient_names[static_cast<std::size_t>(k)],
                    fit->estimate[k],
                    errors[k],
                    k < fit->degrees_of_freedom.size() ? fit->degrees_of_freedom[k] : NAN,
                    t[k],
                    p[k]}));
      }
    }
  }
  return table;
}

void add_components(const ResponseStudy& result,
                    const fit::FittedModel& fit,
                    FormattedTable& table) {
  const auto add = [&](const std::string& component, double value) {
    table.rows.push_back(joined(subject(result), {component, value}));
  };
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    const fit::EstimatedEffects& term = fit.random[k];
    const std::string group = grouping_suffix(fit, k);
    const Eigen::VectorXd deviations = term.sd();
    const Eigen::MatrixXd correlation = term.correlation();
    for (std::size_t i = 0; i < term.names.size(); ++i) {
      add(fmt::format("sd({}{})", term.names[i], group), deviations[static_cast<Eigen::Index>(i)]);
    }
    for (std::size_t i = 0; i < term.names.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        add(fmt::format("cor({}, {}{})", term.names[j], term.names[i], group),
            correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
      }
    }
  }
  add("sigma", fit.sigma);
  const int parameters = fit.variance.function().parameter_count();
  if (parameters > 0) add("delta", fit.variance.delta());
  if (parameters > 1) add("constant", fit.variance.constant());
}

FormattedTable variance_components_table(const Study& study) {
  FormattedTable table{
      .name = "variance_components",
      .caption = "Variance components of the chosen mixed models",
      .columns = joined(kSubject,
                        {{"component", "Component"}, {"value", "Value", ColumnKind::kEstimate}})};
  for (const ResponseStudy& result : study.results) {
    if (result.nlme) add_components(result, result.nlme->fit, table);
  }
  return table;
}

FormattedTable statistics_table(const Study& study) {
  FormattedTable table{
      .name = "statistics",
      .caption = "Fit statistics of the chosen models",
      .columns = joined(joined(joined(kSubject,
                                      {{"level", "Level"},
                                       {"prediction", "Prediction"},
                                       {"formula", "Formula"},
                                       {"n", "n", ColumnKind::kCount}}),
                               kStatistics),
                        {{"k", "k", ColumnKind::kCount},
                         {"log_likelihood", "Log-likelihood", ColumnKind::kCriterion},
                         {"aic", "AIC", ColumnKind::kCriterion},
                         {"bic", "BIC", ColumnKind::kCriterion},
                         {"converged", "Converged"}})};
  for (const ResponseStudy& result : study.results) {
    for (const auto& [level, fit] : chosen_fits(result)) {
      const auto add = [&, &name = level, &model = fit](const std::string& prediction,
                                                        const fit::FitStatistics& values) {
        table.rows.push_back(
            joined(joined(joined(subject(result),
                                 {name,
                                  prediction,
                                  model->specification.formula.text,
                                  number(static_cast<double>(model->observations))}),
                          statistics(values)),
                   {number(model->parameter_count),
                    model->log_likelihood,
                    model->aic(),
                    model->bic(),
                    yes_or_no(model->convergence.converged())}));
      };
      add("population", fit->population);
      if (fit->has_random_effects()) add("conditional", fit->conditional);
    }
  }
  return table;
}

FormattedTable gains_table(const Study& study) {
  FormattedTable table{
      .name = "gains",
      .caption = "Gain of the mixed model over ordinary least squares",
      .columns = joined(kSubject,
                        {{"r2_ols", "R\u00B2 OLS", ColumnKind::kShare},
                         {"r2_nlme", "R\u00B2 NLME", ColumnKind::kShare},
                         {"gain", "Gain (%)", ColumnKind::kPercent},
                         {"rmse_ols", "RMSE OLS", ColumnKind::kShare},
                         {"rmse_nlme", "RMSE NLME", ColumnKind::kShare},
                         {"rmse_reduction", "RMSE lower by (%)", ColumnKind::kPercent},
                         {"aic_ols", "AIC OLS", ColumnKind::kCriterion},
                         {"aic_nlme", "AIC NLME", ColumnKind::kCriterion},
                         {"r2_population", "R\u00B2 NLME, b = 0", ColumnKind::kShare}})};
  for (const ResponseStudy& result : study.results) {
    if (!result.ols || !result.nlme) continue;
    const fit::FitStatistics& ols = result.ols->fit.population;
    const fit::FitStatistics& nlme = result.nlme->fit.conditional;
    table.rows.push_back(joined(subject(result),
                                {ols.r2,
                                 nlme.r2,
                                 100.0 * (nlme.r2 - ols.r2),
                                 ols.rmse,
                                 nlme.rmse,
                                 100.0 * (1.0 - nlme.rmse / ols.rmse),
                                 result.ols->fit.aic(),
                                 result.nlme->fit.aic(),
                                 result.nlme->fit.population.r2}));
  }
  return table;
}

FormattedTable rejected_table(const Study& study) {
  FormattedTable table{
      .name = "rejected",
      .caption = "Candidates that converged and were rejected",
      .columns = joined(kSubject,
                        {{"level", "Level"},
                         {"candidate", "Candidate"},
                         {"rank", "Rank", ColumnKind::kCount},
                         {"log_likelihood", "Log-likelihood", ColumnKind::kCriterion},
                         {"objection", "Objection"}})};
  const std::vector<std::pair<std::vector<Candidate> ResponseStudy::*, std::string>> levels{
      {&ResponseStudy::base, "base"},
      {&ResponseStudy::covariates, "covariates"},
      {&ResponseStudy::random, "random effects"},
      {&ResponseStudy::variance, "variance function"}};
  for (const ResponseStudy& result : study.results) {
    for (const auto& [level, name] : levels) {
      for (const Candidate& candidate : result.*level) {
        if (candidate.objection.empty() || candidate.chosen) continue;
        table.rows.push_back(joined(subject(result),
                                    {name,
                                     name_of(candidate, level),
                                     rank_cell(candidate.rank),
                                     candidate.fit.log_likelihood,
                                     candidate.objection}));
      }
    }
  }
  return table;
}

FormattedTable plots_left_out_table(const Study& study) {
  FormattedTable table{
      .name = "plots_left_out",
      .caption =
          "Predictions for plots left out, random effects zero; t above 0: the mixed model "
          "is worse than the better one of least squares",
      .columns = joined(kSubject,
                        {{"folds", "Folds", ColumnKind::kCount},
                         {"trees", "Trees", ColumnKind::kCount},
                         {"rmse_ols", "RMSE OLS", ColumnKind::kShare},
                         {"rmse_covariates", "RMSE OLS with covariates", ColumnKind::kShare},
                         {"rmse_nlme", "RMSE NLME", ColumnKind::kShare},
                         {"r2_ols", "R\u00B2 OLS", ColumnKind::kShare},
                         {"r2_covariates", "R\u00B2 OLS with covariates", ColumnKind::kShare},
                         {"r2_nlme", "R\u00B2 NLME", ColumnKind::kShare},
                         {"t", "t", ColumnKind::kCriterion},
                         {"worse", "Worse"}})};
  for (const ResponseStudy& result : study.results) {
    if (!result.left_out) continue;
    const LeftOutPlots& left_out = *result.left_out;
    table.rows.push_back(joined(subject(result),
                                {count(left_out.folds),
                                 count(left_out.trees),
                                 left_out.rmse_ols,
                                 left_out.rmse_covariates,
                                 left_out.rmse_nlme,
                                 left_out.r2_ols,
                                 left_out.r2_covariates,
                                 left_out.r2_nlme,
                                 left_out.t,
                                 yes_or_no(left_out.is_worse)}));
  }
  return table;
}

FormattedTable residual_variogram_table(const Study& study) {
  FormattedTable table{
      .name = "residual_variogram",
      .caption = "Variogram of the standardized residuals of the final models, within plots",
      .columns = joined(kSubject,
                        {{"distance", "Distance (m)", ColumnKind::kEstimate},
                         {"semivariance", "Semivariance", ColumnKind::kEstimate},
                         {"pairs", "Pairs", ColumnKind::kCount}})};
  for (const ResponseStudy& result : study.results) {
    for (const VariogramClass& each : result.variogram) {
      table.rows.push_back(
          joined(subject(result), {each.distance_m, each.semivariance, count(each.pairs)}));
    }
  }
  return table;
}

void add_level_tests(const ResponseStudy& result,
                     const StudyOptions& options,
                     FormattedTable& table) {
  const auto fits = chosen_fits(result);
  const std::vector<std::string> letters = letters_of(fits, options);
  for (std::size_t i = 0; i < fits.size(); ++i) {
    table.rows.push_back(joined(joined(joined(subject(result), {fits[i].level, letters[i]}),
                                       {fits[i].fit->log_likelihood, fits[i].fit->aic()}),
                                test_cells(test_against_before(fits, i))));
  }
}

FormattedTable level_tests_table(const Study& study) {
  FormattedTable table{
      .name = "level_tests",
      .caption =
          "Chosen models of the levels, each tested against the one before; "
          "models that share a letter do not differ",
      .columns = joined(joined(kSubject,
                               {{"level", "Level"},
                                {"letters", "Letters"},
                                {"log_likelihood", "Log-likelihood", ColumnKind::kCriterion},
                                {"aic", "AIC", ColumnKind::kCriterion}}),
                        kTest)};
  for (const ResponseStudy& result : study.results) {
    add_level_tests(result, study.options, table);
  }
  return table;
}

}  // namespace

std::vector<FormattedTable> study_tables(const StudyRecord& record, const Catalogue& catalogue) {
  const Study& study = record.study;
  return {species_importance_table(record),
          candidates_table(study, catalogue),
          covariates_table(study),
          random_effects_table(study),
          variance_functions_table(study),
          estimates_table(study),
          variance_components_table(study),
          statistics_table(study),
          gains_table(study),
          level_tests_table(study),
          rejected_table(study),
          plots_left_out_table(study),
          residual_variogram_table(study),
          coefficients_table(study),
          variance_and_fit_table(study),
          plot_effects_table(study)};
}

void write_study_tables(const StudyRecord& record,
                        const Catalogue& catalogue,
                        const std::filesystem::path& folder) {
  for (const FormattedTable& table : study_tables(record, catalogue)) {
    write_file(folder / (table.name + ".csv"), to_csv(table));
    write_file(folder / (table.name + ".md"), to_markdown(table));
    write_file(folder / (table.name + ".tex"), to_latex(table));
  }
}

}  // namespace silvafit::study
