// SPDX-License-Identifier: MIT
// The models that each level of a study tries, and its choice among them.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// A model to be fitted, and how.
struct Trial {
  std::vector<std::string> terms{};
  std::string model{};  ///< id in the catalogue
  fit::ModelSpecification specification;
  fit::FitModelOptions options{};
};

/// A candidate of level 1: an entry of the catalogue, or a formula of the user's own.
struct BaseCandidate {
  const BaseModel* entry = nullptr;
  std::string formula{};

  /// The columns of the table that its mean reads, whether the table has them or not.
  std::vector<std::string> columns(const data::Table& table) const;
};

std::vector<Trial> base_trials(const std::vector<BaseCandidate>& candidates,
                               const data::Table& table);

/// Subsets of the covariates on each parameter of a base model, or with two parameters at once also
/// on each pair; the base model itself first.
/// \throws UsageError if there are more than 4096
std::vector<Trial> covariate_trials(const fit::FittedModel& base,
                                    const std::vector<std::string>& covariates,
                                    std::size_t parameters_at_once,
                                    const data::Table& table);

/// The chosen model of level 2 without the intercept of its sub-model, if there is one.
std::optional<Trial> without_intercept(const Candidate& chosen, const data::Table& table);

/// Random effects on every subset of coefficients up to a size.
std::vector<Trial> random_effect_trials(const fit::FittedModel& fixed,
                                        const std::string& group,
                                        std::size_t largest);

/// A chosen mixed model with random effects of a further grouping, on every subset of coefficients
/// up to a size. Their terms are the texts of all groupings.
/// \param added  without coefficients; if it is crossed, or those of the model are, all are
std::vector<Trial> added_term_trials(const Candidate& mixed,
                                     const fit::RandomEffects& added,
                                     std::size_t largest);

/// A mixed model of several groupings with random effects of the first one on every subset of
/// coefficients up to a size; none of a model with one grouping. Terms as in added_term_trials().
std::vector<Trial> exchanged_term_trials(const Candidate& mixed, std::size_t largest);

/// The chosen mixed model with each variance function, none first. They start from its fit, which
/// must remain in memory during the fits.
std::vector<Trial> variance_trials(const Candidate& mixed,
                                   const std::vector<std::string>& functions);

/// The reason for rejecting the candidate of an index, as a sentence; empty: none. Called at most
/// once per candidate, and only for those that would be chosen.
using Examination = std::function<std::string(std::size_t)>;

/// The choices of the levels (see run_study for the rules). Each ranks its candidates, rejects
/// those with an objection, marks the chosen one and returns its index; nothing if none converged
/// or, except at level 1, all have an objection. Level 1 then chooses the best one with its
/// objection, so that there is a model for the data.
std::optional<std::size_t> choose_base(std::vector<Candidate>& candidates,
                                       const StudyOptions& options,
                                       const Examination& examine = {});
std::optional<std::size_t> choose_covariates(std::vector<Candidate>& candidates,
                                             const StudyOptions& options,
                                             const Examination& examine = {});
std::optional<std::size_t> choose_random_effects(std::vector<Candidate>& candidates,
                                                 const StudyOptions& options,
                                                 const Examination& examine = {});
std::optional<std::size_t> choose_variance(std::vector<Candidate>& candidates,
                                           const StudyOptions& options,
                                           const Examination& examine = {});

}  // namespace silvafit::study
