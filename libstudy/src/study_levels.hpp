// SPDX-License-Identifier: MIT
// The models that each level of a study tries, and which of them it chooses.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// A model to be fitted: which, and how.
struct Trial {
  std::vector<std::string> terms{};
  std::string model{};  ///< id in the catalogue
  fit::ModelSpecification specification;
  fit::FitModelOptions options{};
};

std::vector<Trial> base_trials(const std::vector<const BaseModel*>& candidates,
                               const data::Table& table);

/// Subsets of the covariates on each parameter of a base model, the base model itself first.
std::vector<Trial> covariate_trials(const fit::FittedModel& base,
                                    const std::vector<std::string>& covariates,
                                    const data::Table& table);

/// The chosen model of level 2 with the intercept of its sub-model left out, if it has one to lose.
std::optional<Trial> without_intercept(const Candidate& chosen, const data::Table& table);

/// Random effects on every subset of coefficients up to a size.
std::vector<Trial> random_effect_trials(const fit::FittedModel& fixed,
                                        const std::string& group,
                                        std::size_t largest);

/// The chosen mixed model with each variance function, none first.
std::vector<Trial> variance_trials(const Candidate& mixed);

/// The choices of the levels (run_study has the rules). Each ranks its candidates, marks the chosen
/// one and gives its index; nothing if none converged.
std::optional<std::size_t> choose_base(std::vector<Candidate>& candidates,
                                       Criterion criterion = Criterion::kByLevel);
std::optional<std::size_t> choose_covariates(std::vector<Candidate>& candidates,
                                             Criterion criterion = Criterion::kByLevel);
std::optional<std::size_t> choose_random_effects(std::vector<Candidate>& candidates,
                                                 Criterion criterion = Criterion::kByLevel);
std::optional<std::size_t> choose_variance(std::vector<Candidate>& candidates,
                                           Criterion criterion = Criterion::kByLevel);

/// Twice the gain in log-likelihood against chi-squared with the difference in parameters.
LikelihoodRatioTest likelihood_ratio_test(const fit::FittedModel& larger,
                                          const fit::FittedModel& smaller);

}  // namespace silvafit::study
