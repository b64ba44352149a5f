// SPDX-License-Identifier: MIT
// The tables of a study as CSV files.
#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/study_files.hpp"

namespace silvafit::study {
namespace {

std::string field(const std::string& text) { return data::csv_field(text); }
std::string field(double value) { return std::isfinite(value) ? data::shortest(value) : ""; }
std::string field(int value) { return std::to_string(value); }
std::string rank_field(int rank) { return rank > 0 ? std::to_string(rank) : ""; }
std::string yes_or_no(bool value) { return value ? "yes" : "no"; }

/// A CSV file that grows line by line.
class Lines {
 public:
  explicit Lines(const std::vector<std::string>& header) { add(header); }

  void add(const std::vector<std::string>& fields) {
    text_ += fmt::format("{}\n", fmt::join(fields, ","));
  }
  void write(const std::filesystem::path& path) const { write_file(path, text_); }

 private:
  std::string text_;
};

using Fields = std::vector<std::string>;

Fields joined(Fields first, const Fields& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

Fields subject(const ResponseStudy& result) {
  return {field(result.species), field(result.response)};
}

const Fields kCriteriaHeader{
    "k", "log_likelihood", "aic", "bic", "rank", "chosen", "converged", "verdict"};

Fields criteria(const Candidate& candidate) {
  const fit::FittedModel& fit = candidate.fit;
  return {field(fit.parameter_count),
          field(fit.log_likelihood),
          field(fit.aic()),
          field(fit.bic()),
          rank_field(candidate.rank),
          yes_or_no(candidate.chosen),
          yes_or_no(fit.convergence.converged),
          field(fit.convergence.verdict)};
}

const Fields kStatisticsHeader{"r2", "mean_error", "rmse", "mae"};

Fields statistics(const fit::FitStatistics& values) {
  return {field(values.r2), field(values.mean_error), field(values.rmse), field(values.mae)};
}

const Fields kTestHeader{"likelihood_ratio", "df", "p"};

Fields test(const Candidate& candidate) {
  if (!candidate.test) return {"", "", ""};
  return {field(candidate.test->statistic),
          field(candidate.test->degrees_of_freedom),
          field(candidate.test->p)};
}

void write_candidates(const Study& study,
                      const Catalogue& catalogue,
                      const std::filesystem::path& folder) {
  Lines lines(joined(joined({"species", "response", "model", "name", "formula"}, kStatisticsHeader),
                     kCriteriaHeader));
  for (const ResponseStudy& result : study.results) {
    for (const Candidate& candidate : result.base) {
      const BaseModel& model = catalogue.find(candidate.fit.model);
      lines.add(joined(joined(joined(subject(result),
                                     {field(model.id), field(model.name), field(model.formula)}),
                              statistics(candidate.fit.population)),
                       criteria(candidate)));
    }
  }
  lines.write(folder / "candidates.csv");
}

void write_covariates(const Study& study, const std::filesystem::path& folder) {
  Lines lines(
      joined(joined(joined({"species", "response", "sub_models"}, kStatisticsHeader), kTestHeader),
             kCriteriaHeader));
  for (const ResponseStudy& result : study.results) {
    for (const Candidate& candidate : result.covariates) {
      const std::string terms = fmt::format("{}", fmt::join(candidate.terms, "; "));
      lines.add(joined(joined(joined(joined(subject(result), {field(terms)}),
                                     statistics(candidate.fit.population)),
                              test(candidate)),
                       criteria(candidate)));
    }
  }
  lines.write(folder / "covariates.csv");
}

void write_random_effects(const Study& study, const std::filesystem::path& folder) {
  Lines lines(joined(joined({"species", "response", "random_effects", "covariance"}, kTestHeader),
                     kCriteriaHeader));
  for (const ResponseStudy& result : study.results) {
    for (const Candidate& candidate : result.random) {
      const std::string terms = fmt::format("{}", fmt::join(candidate.terms, " + "));
      lines.add(joined(
          joined(joined(subject(result),
                        {field(terms),
                         fit::covariance_text(candidate.fit.specification.random->covariance)}),
                 test(candidate)),
          criteria(candidate)));
    }
  }
  lines.write(folder / "random_effects.csv");
}

void write_variance_functions(const Study& study, const std::filesystem::path& folder) {
  Lines lines(joined(joined({"species", "response", "function", "delta", "constant"}, kTestHeader),
                     kCriteriaHeader));
  for (const ResponseStudy& result : study.results) {
    for (const Candidate& candidate : result.variance) {
      const fit::VarianceEstimate& variance = candidate.fit.variance;
      const fit::VarianceFunction function = variance.function();
      const int count = function.parameter_count();
      lines.add(joined(joined(joined(subject(result),
                                     {field(function.text()),
                                      count > 0 ? field(variance.delta()) : "",
                                      count > 1 ? field(variance.constant()) : ""}),
                              test(candidate)),
                       criteria(candidate)));
    }
  }
  lines.write(folder / "variance_functions.csv");
}

/// The chosen fits of a result under the names of their levels.
std::vector<std::pair<std::string, const fit::FittedModel*>> chosen_fits(
    const ResponseStudy& result) {
  std::vector<std::pair<std::string, const fit::FittedModel*>> fits;
  if (result.ols) fits.emplace_back("ols", &result.ols->fit);
  if (result.with_covariates) fits.emplace_back("covariates", &result.with_covariates->fit);
  if (result.nlme) fits.emplace_back("nlme", &result.nlme->fit);
  return fits;
}

void write_estimates(const Study& study, const std::filesystem::path& folder) {
  Lines lines({"species", "response", "level", "coefficient", "estimate", "se", "df", "t", "p"});
  for (const ResponseStudy& result : study.results) {
    for (const auto& [level, fit] : chosen_fits(result)) {
      const Eigen::VectorXd errors = fit->standard_errors();
      const Eigen::VectorXd t = fit->t_values();
      const Eigen::VectorXd p = fit->p_values();
      for (Eigen::Index k = 0; k < fit->estimate.size(); ++k) {
        lines.add(
            joined(subject(result),
                   {level,
                    field(fit->coefficient_names[static_cast<std::size_t>(k)]),
                    field(fit->estimate[k]),
                    field(errors[k]),
                    field(k < fit->degrees_of_freedom.size() ? fit->degrees_of_freedom[k] : NAN),
                    field(t[k]),
                    field(p[k])}));
      }
    }
  }
  lines.write(folder / "estimates.csv");
}

void add_components(const ResponseStudy& result, const fit::FittedModel& fit, Lines& lines) {
  const auto add = [&](const std::string& component, double value) {
    lines.add(joined(subject(result), {field(component), field(value)}));
  };
  const Eigen::VectorXd deviations = fit.random_sd();
  const Eigen::MatrixXd correlation = fit.random_correlation();
  for (std::size_t i = 0; i < fit.random_names.size(); ++i) {
    add(fmt::format("sd({})", fit.random_names[i]), deviations[static_cast<Eigen::Index>(i)]);
  }
  for (std::size_t i = 0; i < fit.random_names.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      add(fmt::format("cor({}, {})", fit.random_names[j], fit.random_names[i]),
          correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
    }
  }
  add("sigma", fit.sigma);
  const int count = fit.variance.function().parameter_count();
  if (count > 0) add("delta", fit.variance.delta());
  if (count > 1) add("constant", fit.variance.constant());
}

void write_variance_components(const Study& study, const std::filesystem::path& folder) {
  Lines lines({"species", "response", "component", "value"});
  for (const ResponseStudy& result : study.results) {
    if (result.nlme) add_components(result, result.nlme->fit, lines);
  }
  lines.write(folder / "variance_components.csv");
}

void write_statistics(const Study& study, const std::filesystem::path& folder) {
  Lines lines(joined(
      joined({"species", "response", "level", "prediction", "formula", "n"}, kStatisticsHeader),
      {"k", "log_likelihood", "aic", "bic", "converged"}));
  for (const ResponseStudy& result : study.results) {
    for (const auto& [level, fit] : chosen_fits(result)) {
      const auto add = [&, &name = level, &model = fit](const std::string& prediction,
                                                        const fit::FitStatistics& values) {
        lines.add(joined(joined(joined(subject(result),
                                       {name,
                                        prediction,
                                        field(model->specification.formula.text),
                                        std::to_string(model->observations)}),
                                statistics(values)),
                         {field(model->parameter_count),
                          field(model->log_likelihood),
                          field(model->aic()),
                          field(model->bic()),
                          yes_or_no(model->convergence.converged)}));
      };
      add("population", fit->population);
      if (fit->has_random_effects()) add("conditional", fit->conditional);
    }
  }
  lines.write(folder / "statistics.csv");
}

}  // namespace

void write_study_tables(const StudyRecord& record,
                        const Catalogue& catalogue,
                        const std::filesystem::path& folder) {
  write_candidates(record.study, catalogue, folder);
  write_covariates(record.study, folder);
  write_random_effects(record.study, folder);
  write_variance_functions(record.study, folder);
  write_estimates(record.study, folder);
  write_variance_components(record.study, folder);
  write_statistics(record.study, folder);
}

}  // namespace silvafit::study
