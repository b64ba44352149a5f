// SPDX-License-Identifier: MIT
#include "study/study_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "silvafit/data/column_reference.hpp"

namespace silvafit::study {
namespace {

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
  return candidate.fit.convergence.converged() && std::isfinite(candidate.fit.log_likelihood);
}

bool is_at_boundary(const Candidate& candidate) { return candidate.fit.convergence.has_boundary(); }

/// The sort key of a candidate, smaller being better: first the number of failed folds, because an
/// error without them is not comparable, then the criterion.
using Score = std::pair<std::size_t, double>;

Score cross_validated_score(const Candidate& candidate) {
  constexpr double kWorst = std::numeric_limits<double>::infinity();
  if (!candidate.cross_validated || std::isnan(candidate.cross_validated->rmse)) {
    return {std::numeric_limits<std::size_t>::max(), kWorst};
  }
  return {candidate.cross_validated->failed, candidate.cross_validated->rmse};
}

Score score_of(Criterion criterion, const Candidate& candidate) {
  switch (criterion) {
    case Criterion::kAic:
      return {0, candidate.fit.aic()};
    case Criterion::kAicc:
      return {0, candidate.fit.aicc()};
    case Criterion::kBic:
      return {0, candidate.fit.bic()};
    case Criterion::kCrossValidation:
      break;
  }
  return cross_validated_score(candidate);
}

/// Distance from the best score within which models are equally good; of errors, one standard
/// error.
double tolerance_of(Criterion criterion, const Candidate& best, const StudyOptions& options) {
  if (criterion != Criterion::kCrossValidation) return options.equally_good;
  if (!best.cross_validated || std::isnan(best.cross_validated->standard_error)) return 0.0;
  return best.cross_validated->standard_error;
}

/// Ranks the usable candidates by a criterion; ties keep their order.
std::vector<std::size_t> ranked(std::vector<Candidate>& candidates, Criterion criterion) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    candidates[i].rank = 0;
    candidates[i].chosen = false;
    if (is_usable(candidates[i])) order.push_back(i);
  }
  std::ranges::stable_sort(
      order, {}, [&](std::size_t i) { return score_of(criterion, candidates[i]); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    candidates[order[i]].rank = static_cast<int>(i) + 1;
  }
  return order;
}

std::optional<std::size_t> mark(std::vector<Candidate>& candidates, std::size_t chosen) {
  candidates[chosen].chosen = true;
  return chosen;
}

/// Whether there is no objection to a candidate.
bool passes(Candidate& candidate, std::size_t index, const Examination& examine) {
  if (!examine) return true;
  if (!candidate.is_examined) candidate.objection = examine(index);
  candidate.is_examined = true;
  return candidate.objection.empty();
}

/// The ranking from the first acceptable candidate on; empty if there is none.
std::vector<std::size_t> from_first_passing(std::vector<Candidate>& candidates,
                                            const std::vector<std::size_t>& order,
                                            const Examination& examine) {
  const auto first =
      std::ranges::find_if(order, [&](std::size_t i) { return passes(candidates[i], i, examine); });
  return {first, order.end()};
}

/// The first in order that is acceptable and, if tests are required, significant. Candidates
/// without a test are chosen by rank: the reference of the tests, and models not nested with it.
std::optional<std::size_t> first_significant(std::vector<Candidate>& candidates,
                                             const std::vector<std::size_t>& order,
                                             const StudyOptions& options,
                                             const Examination& examine) {
  for (const std::size_t i : order) {
    const bool needs_test = options.needs_tests && candidates[i].test.has_value();
    if (needs_test && !(candidates[i].test->p < options.significance)) continue;
    if (passes(candidates[i], i, examine)) return mark(candidates, i);
  }
  return std::nullopt;
}

/// The candidates in order that are equally good as the first.
std::vector<std::size_t> equally_good(const std::vector<Candidate>& candidates,
                                      const std::vector<std::size_t>& order,
                                      Criterion criterion,
                                      const StudyOptions& options) {
  const Score best = score_of(criterion, candidates[order.front()]);
  const double tolerance = tolerance_of(criterion, candidates[order.front()], options);
  std::vector<std::size_t> result;
  std::ranges::copy_if(order, std::back_inserter(result), [&](std::size_t i) {
    const Score score = score_of(criterion, candidates[i]);
    return score.first == best.first && score.second <= best.second + tolerance;
  });
  return result;
}

/// Sorts by the number of parameters; equal ones keep their order.
std::vector<std::size_t> simplest_first(const std::vector<Candidate>& candidates,
                                        std::vector<std::size_t> order) {
  std::ranges::stable_sort(
      order, {}, [&](std::size_t i) { return candidates[i].fit.parameter_count; });
  return order;
}

/// The sub-models of a parameter with every subset of covariates but the empty one.
std::vector<fit::ParameterModel> extended(const fit::ParameterModel& parameter,
                                          const std::vector<std::string>& covariates) {
  std::vector<fit::ParameterModel> result;
  for (std::size_t subset = 1; subset < (std::size_t{1} << covariates.size()); ++subset) {
    fit::ParameterModel model = parameter;
    for (const std::string& name : members_of(covariates, subset)) {
      model.covariates.push_back(column_covariate(name));
    }
    result.push_back(std::move(model));
  }
  return result;
}

/// Whether one start suffices; the likelihood of a constant plus a power has several maxima.
bool has_one_start(const fit::VarianceFunction& function) {
  return std::ranges::none_of(function.factors, [](const fit::VarianceFactor& factor) {
    return factor.kind == fit::VarianceFactor::Kind::kConstantPlusPower;
  });
}

/// A trial with other sub-models of some parameters; new coefficients start at zero.
Trial with_sub_models(Trial trial,
                      const std::vector<std::pair<std::size_t, fit::ParameterModel>>& models) {
  for (const auto& [parameter, model] : models) {
    trial.specification.parameters[parameter] = model;
    for (const std::string& name : model.coefficient_names())
      trial.options.start.emplace(name, 0.0);
    trial.terms.push_back(model.name + " ~ " + model.text());
  }
  return trial;
}

/// \throws UsageError if all subsets of the covariates are too many
void check_trials(std::size_t parameters, std::size_t covariates, std::size_t at_once) {
  // Minutes to an hour, a fit of some hundred trees taking a hundredth of a second to a second.
  constexpr double kMostTrials = 4096.0;
  const double subsets = std::exp2(static_cast<double>(covariates)) - 1.0;
  const auto p = static_cast<double>(parameters);
  const double pairs = at_once > 1 ? 0.5 * p * (p - 1.0) : 0.0;
  const double trials = p * subsets + pairs * subsets * subsets;
  if (trials <= kMostTrials) return;
  throw UsageError(
      fmt::format(
          "every subset of {} covariates on {} of {} parameters makes {:.0f} fits, of which "
          "at most {:.0f} are made; name fewer covariates{}",
          covariates,
          at_once > 1 ? "one or two" : "one",
          parameters,
          trials,
          kMostTrials,
          at_once > 1 ? ", or use covariate_parameters 1" : ""),
      {.column = "`covariates`"});
}

}  // namespace

std::vector<std::string> BaseCandidate::columns(const data::Table& table) const {
  if (entry != nullptr) return entry->covariates;
  std::vector<std::string> columns;
  for (const std::string& name : fit::specify_model(formula, {}, table).predictors()) {
    columns.push_back(data::column_of(name));
  }
  return columns;
}

std::vector<Trial> base_trials(const std::vector<BaseCandidate>& candidates,
                               const data::Table& table) {
  std::vector<Trial> trials;
  for (const BaseCandidate& candidate : candidates) {
    Trial trial{.specification = fit::specify_model(candidate.formula, {}, table)};
    if (candidate.entry != nullptr) {
      trial.model = candidate.entry->id;
      const std::vector<double> starts = start_values(*candidate.entry, table);
      for (std::size_t k = 0; k < starts.size(); ++k) {
        trial.options.rule[candidate.entry->parameters[k].name] = starts[k];
      }
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

std::vector<Trial> covariate_trials(const fit::FittedModel& base,
                                    const std::vector<std::string>& covariates,
                                    std::size_t parameters_at_once,
                                    const data::Table& table) {
  Trial reference{.model = base.model, .specification = base.specification};
  for (Eigen::Index k = 0; k < base.estimate.size(); ++k) {
    reference.options.start[base.coefficient_names[static_cast<std::size_t>(k)]] = base.estimate[k];
  }
  std::vector<Trial> trials{reference};
  if (table.rows() == 0) return trials;
  const std::vector<fit::ParameterModel>& parameters = base.specification.parameters;
  check_trials(parameters.size(), covariates.size(), parameters_at_once);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    for (const fit::ParameterModel& model : extended(parameters[i], covariates)) {
      trials.push_back(with_sub_models(reference, {{i, model}}));
    }
  }
  for (std::size_t i = 0; i < parameters.size() && parameters_at_once > 1; ++i) {
    for (std::size_t j = i + 1; j < parameters.size(); ++j) {
      for (const fit::ParameterModel& first : extended(parameters[i], covariates)) {
        for (const fit::ParameterModel& second : extended(parameters[j], covariates)) {
          trials.push_back(with_sub_models(reference, {{i, first}, {j, second}}));
        }
      }
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
    trial.specification.random = {{.coefficients = trial.terms, .group = group}};
    trial.options.method = fit::Method::kLindstromBates;
    for (Eigen::Index k = 0; k < fixed.estimate.size(); ++k) {
      trial.options.start[fixed.coefficient_names[static_cast<std::size_t>(k)]] = fixed.estimate[k];
    }
    trials.push_back(std::move(trial));
  }
  std::ranges::stable_sort(trials, {}, [](const Trial& trial) { return trial.terms.size(); });
  return trials;
}

namespace {

/// A trial with random effects of several groupings, whose texts are its terms.
Trial with_random_terms(Trial trial, std::vector<fit::RandomEffects> terms, bool are_crossed) {
  trial.terms.clear();
  for (fit::RandomEffects& term : terms) {
    term.is_crossed = are_crossed;
    trial.terms.push_back(fmt::format("{} | {}", term.text(), term.group_text()));
  }
  trial.specification.random = std::move(terms);
  return trial;
}

}  // namespace

std::vector<Trial> added_term_trials(const Candidate& mixed,
                                     const fit::RandomEffects& added,
                                     std::size_t largest) {
  const std::vector<fit::RandomEffects>& known = mixed.fit.specification.random;
  std::vector<Trial> trials;
  for (Trial& trial : random_effect_trials(mixed.fit, added.group, largest)) {
    std::vector<fit::RandomEffects> terms = known;
    terms.push_back(added);
    terms.back().coefficients = trial.terms;
    trials.push_back(with_random_terms(
        std::move(trial), std::move(terms), added.is_crossed || fit::are_crossed(known)));
  }
  return trials;
}

std::vector<Trial> exchanged_term_trials(const Candidate& mixed, std::size_t largest) {
  const std::vector<fit::RandomEffects>& known = mixed.fit.specification.random;
  std::vector<Trial> trials;
  if (known.size() < 2) return trials;
  for (Trial& trial : random_effect_trials(mixed.fit, known.front().group, largest)) {
    std::vector<fit::RandomEffects> terms = known;
    terms.front().coefficients = trial.terms;
    trials.push_back(
        with_random_terms(std::move(trial), std::move(terms), fit::are_crossed(known)));
  }
  return trials;
}

std::vector<Trial> variance_trials(const Candidate& mixed,
                                   const std::vector<std::string>& functions) {
  std::vector<std::string> all{"none"};
  std::ranges::copy_if(
      functions, std::back_inserter(all), [](const std::string& text) { return text != "none"; });
  std::vector<Trial> trials;
  for (const std::string& function : all) {
    Trial trial{
        .terms = mixed.terms, .model = mixed.fit.model, .specification = mixed.fit.specification};
    trial.specification.variance = fit::parse_variance_function(function);
    trial.options.method = fit::Method::kLindstromBates;
    if (has_one_start(trial.specification.variance)) trial.options.from = &mixed.fit;
    for (Eigen::Index k = 0; k < mixed.fit.estimate.size(); ++k) {
      trial.options.start[mixed.fit.coefficient_names[static_cast<std::size_t>(k)]] =
          mixed.fit.estimate[k];
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

std::optional<std::size_t> choose_base(std::vector<Candidate>& candidates,
                                       const StudyOptions& options,
                                       const Examination& examine) {
  const Criterion criterion = options.criteria.base;
  const std::vector<std::size_t> all = ranked(candidates, criterion);
  if (all.empty()) return std::nullopt;
  const std::vector<std::size_t> order = from_first_passing(candidates, all, examine);
  if (order.empty()) return mark(candidates, all.front());
  const auto close =
      simplest_first(candidates, equally_good(candidates, order, criterion, options));
  return mark(candidates, from_first_passing(candidates, close, examine).front());
}

std::optional<std::size_t> choose_covariates(std::vector<Candidate>& candidates,
                                             const StudyOptions& options,
                                             const Examination& examine) {
  return first_significant(
      candidates, ranked(candidates, options.criteria.covariates), options, examine);
}

std::optional<std::size_t> choose_random_effects(std::vector<Candidate>& candidates,
                                                 const StudyOptions& options,
                                                 const Examination& examine) {
  const Criterion criterion = options.criteria.random;
  const std::vector<std::size_t> all = ranked(candidates, criterion);
  std::vector<std::size_t> inside;
  std::ranges::copy_if(all, std::back_inserter(inside), [&](std::size_t i) {
    return !is_at_boundary(candidates[i]);
  });
  std::vector<std::size_t> order = from_first_passing(candidates, inside, examine);
  if (order.empty()) order = from_first_passing(candidates, all, examine);
  if (order.empty()) return std::nullopt;
  if (!options.parsimonious) return mark(candidates, order.front());
  const auto close =
      simplest_first(candidates, equally_good(candidates, order, criterion, options));
  return mark(candidates, from_first_passing(candidates, close, examine).front());
}

std::optional<std::size_t> choose_variance(std::vector<Candidate>& candidates,
                                           const StudyOptions& options,
                                           const Examination& examine) {
  const Criterion criterion = options.criteria.variance;
  std::vector<std::size_t> order = ranked(candidates, criterion);
  if (options.parsimonious && !order.empty()) {
    order = simplest_first(candidates, equally_good(candidates, order, criterion, options));
  }
  return first_significant(candidates, order, options, examine);
}

}  // namespace silvafit::study
