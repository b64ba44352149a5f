// SPDX-License-Identifier: MIT
#include "study_levels.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

namespace silvafit::study {
namespace {

constexpr double kSignificant = 0.05;
// Within 2 AIC of the best, a model is as good as the best.
constexpr double kEquallyGood = 2.0;

std::vector<std::string> members_of(const std::vector<std::string>& names, std::size_t subset) {
  std::vector<std::string> members;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if ((subset >> k & 1U) != 0) members.push_back(names[k]);
  }
  return members;
}

fit::Covariate column_covariate(const std::string& name) {
  return {.label = name, .value = data::Expression::variable(name)};
}

bool is_usable(const Candidate& candidate) {
  return candidate.fit.convergence.converged && std::isfinite(candidate.fit.log_likelihood);
}

bool is_on_edge(const Candidate& candidate) { return !candidate.fit.convergence.boundary.empty(); }

/// Ranks the usable candidates by a criterion; ties keep their order.
template <typename Criterion>
std::vector<std::size_t> ranked(std::vector<Candidate>& candidates, Criterion criterion) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    candidates[i].rank = 0;
    candidates[i].chosen = false;
    if (is_usable(candidates[i])) order.push_back(i);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return criterion(candidates[i]); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    candidates[order[i]].rank = static_cast<int>(i) + 1;
  }
  return order;
}

/// What ranks the candidates of a level, smaller being better.
using Ranking = std::function<std::pair<double, double>(const Candidate&)>;

/// Folds that failed first: an error that leaves them out is not comparable.
std::pair<double, double> cross_validated_of(const Candidate& candidate) {
  constexpr double kWorst = std::numeric_limits<double>::infinity();
  if (!candidate.cross_validated) return {kWorst, kWorst};
  const double rmse = candidate.cross_validated->rmse;
  return {static_cast<double>(candidate.cross_validated->failed), std::isnan(rmse) ? kWorst : rmse};
}

/// \param own  of the level, where it has its own
Ranking ranking_by(Criterion criterion, Criterion own) {
  switch (criterion == Criterion::kByLevel ? own : criterion) {
    case Criterion::kAicc:
      return [](const Candidate& candidate) { return std::pair(0.0, candidate.fit.aicc()); };
    case Criterion::kBic:
      return [](const Candidate& candidate) { return std::pair(0.0, candidate.fit.bic()); };
    case Criterion::kCrossValidation:
      return cross_validated_of;
    default:
      return [](const Candidate& candidate) { return std::pair(0.0, candidate.fit.aic()); };
  }
}

std::optional<std::size_t> mark(std::vector<Candidate>& candidates, std::size_t chosen) {
  candidates[chosen].chosen = true;
  return chosen;
}

/// The first in order whose test is significant. Candidates without a test stand on their rank: the
/// reference of the tests, and what is not nested with it.
std::optional<std::size_t> first_significant(std::vector<Candidate>& candidates,
                                             const std::vector<std::size_t>& order) {
  for (const std::size_t i : order) {
    const bool is_untested = !candidates[i].test.has_value();
    if (is_untested || candidates[i].test->p < kSignificant) return mark(candidates, i);
  }
  return std::nullopt;
}

std::optional<std::size_t> first_of(std::vector<Candidate>& candidates,
                                    const std::vector<std::size_t>& order) {
  if (order.empty()) return std::nullopt;
  return mark(candidates, order.front());
}

}  // namespace

LikelihoodRatioTest likelihood_ratio_test(const fit::FittedModel& larger,
                                          const fit::FittedModel& smaller) {
  LikelihoodRatioTest test;
  test.statistic = 2.0 * (larger.log_likelihood - smaller.log_likelihood);
  test.degrees_of_freedom = larger.parameter_count - smaller.parameter_count;
  if (test.degrees_of_freedom > 0 && test.statistic > 0.0) {
    const boost::math::chi_squared distribution(test.degrees_of_freedom);
    test.p = boost::math::cdf(boost::math::complement(distribution, test.statistic));
  }
  return test;
}

std::vector<Trial> base_trials(const std::vector<const BaseModel*>& candidates,
                               const data::Table& table) {
  std::vector<Trial> trials;
  for (const BaseModel* model : candidates) {
    Trial trial{.model = model->id, .specification = fit::specify_model(model->formula, {}, table)};
    const std::vector<double> starts = start_values(*model, table);
    for (std::size_t k = 0; k < starts.size(); ++k) {
      trial.options.rule[model->parameters[k].name] = starts[k];
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

std::vector<Trial> covariate_trials(const fit::FittedModel& base,
                                    const std::vector<std::string>& covariates,
                                    const data::Table& table) {
  Trial reference{.model = base.model, .specification = base.specification};
  for (Eigen::Index k = 0; k < base.estimate.size(); ++k) {
    reference.options.start[base.coefficient_names[static_cast<std::size_t>(k)]] = base.estimate[k];
  }
  std::vector<Trial> trials{reference};
  if (table.rows() == 0) return trials;
  for (std::size_t parameter = 0; parameter < base.specification.parameters.size(); ++parameter) {
    for (std::size_t subset = 1; subset < (std::size_t{1} << covariates.size()); ++subset) {
      Trial trial = reference;
      fit::ParameterModel& model = trial.specification.parameters[parameter];
      for (const std::string& name : members_of(covariates, subset)) {
        model.covariates.push_back(column_covariate(name));
        trial.options.start[model.name + ":" + name] = 0.0;
      }
      trial.terms.push_back(model.name + " ~ " + model.text());
      trials.push_back(std::move(trial));
    }
  }
  return trials;
}

std::optional<Trial> without_intercept(const Candidate& chosen, const data::Table& table) {
  if (chosen.terms.empty() || table.rows() == 0) return std::nullopt;
  Trial trial{.model = chosen.fit.model, .specification = chosen.fit.specification};
  for (fit::ParameterModel& model : trial.specification.parameters) {
    if (model.covariates.empty()) continue;
    model.has_intercept = false;
    trial.terms.push_back(model.name + " ~ " + model.text());
  }
  return trial;
}

std::vector<Trial> random_effect_trials(const fit::FittedModel& fixed,
                                        const std::string& group,
                                        std::size_t largest) {
  std::vector<Trial> trials;
  for (std::size_t subset = 1; subset < (std::size_t{1} << fixed.coefficient_names.size());
       ++subset) {
    Trial trial{.terms = members_of(fixed.coefficient_names, subset),
                .model = fixed.model,
                .specification = fixed.specification};
    if (trial.terms.size() > largest) continue;
    trial.specification.random = fit::RandomEffects{.coefficients = trial.terms, .group = group};
    trial.options.method = fit::Method::kLindstromBates;
    for (Eigen::Index k = 0; k < fixed.estimate.size(); ++k) {
      trial.options.start[fixed.coefficient_names[static_cast<std::size_t>(k)]] = fixed.estimate[k];
    }
    trials.push_back(std::move(trial));
  }
  std::ranges::stable_sort(trials, {}, [](const Trial& trial) { return trial.terms.size(); });
  return trials;
}

std::vector<Trial> variance_trials(const Candidate& mixed) {
  std::vector<Trial> trials;
  for (const char* const function : {"none", "exponential", "power", "constant-plus-power"}) {
    Trial trial{
        .terms = mixed.terms, .model = mixed.fit.model, .specification = mixed.fit.specification};
    trial.specification.variance = fit::parse_variance_function(function);
    trial.options.method = fit::Method::kLindstromBates;
    for (Eigen::Index k = 0; k < mixed.fit.estimate.size(); ++k) {
      trial.options.start[mixed.fit.coefficient_names[static_cast<std::size_t>(k)]] =
          mixed.fit.estimate[k];
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

std::optional<std::size_t> choose_base(std::vector<Candidate>& candidates, Criterion criterion) {
  const Ranking ranking = ranking_by(criterion, Criterion::kAic);
  const std::vector<std::size_t> order = ranked(candidates, ranking);
  if (order.empty()) return std::nullopt;
  std::size_t chosen = order.front();
  // Errors have no such scale.
  if (criterion == Criterion::kCrossValidation) return mark(candidates, chosen);
  const double best = ranking(candidates[chosen]).second;
  for (const std::size_t i : order) {
    const bool close = ranking(candidates[i]).second <= best + kEquallyGood;
    if (close && candidates[i].fit.parameter_count < candidates[chosen].fit.parameter_count) {
      chosen = i;
    }
  }
  return mark(candidates, chosen);
}

std::optional<std::size_t> choose_covariates(std::vector<Candidate>& candidates,
                                             Criterion criterion) {
  const std::vector<std::size_t> order = ranked(candidates, ranking_by(criterion, Criterion::kBic));
  if (criterion == Criterion::kByLevel) return first_significant(candidates, order);
  return first_of(candidates, order);
}

std::optional<std::size_t> choose_random_effects(std::vector<Candidate>& candidates,
                                                 Criterion criterion) {
  const std::vector<std::size_t> order = ranked(candidates, ranking_by(criterion, Criterion::kBic));
  if (order.empty()) return std::nullopt;
  const auto inside =
      std::ranges::find_if_not(order, [&](std::size_t i) { return is_on_edge(candidates[i]); });
  return mark(candidates, inside == order.end() ? order.front() : *inside);
}

std::optional<std::size_t> choose_variance(std::vector<Candidate>& candidates,
                                           Criterion criterion) {
  const std::vector<std::size_t> order = ranked(candidates, ranking_by(criterion, Criterion::kAic));
  if (criterion == Criterion::kByLevel) return first_significant(candidates, order);
  return first_of(candidates, order);
}

}  // namespace silvafit::study
