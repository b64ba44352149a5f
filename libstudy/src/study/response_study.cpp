// SPDX-License-Identifier: MIT
// The results of a study for one species and response.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "silvafit/study/study.hpp"

namespace silvafit::study {
namespace {

using Level = std::vector<Candidate> ResponseStudy::*;

/// The levels and the names of their candidates.
const std::vector<std::pair<Level, std::string>> kLevels{
    {&ResponseStudy::base, "base model"},
    {&ResponseStudy::covariates, "covariates"},
    {&ResponseStudy::random, "random effects"},
    {&ResponseStudy::variance, "variance function"}};

/// Sub-models, and the random effects of two groupings, are separate; coefficients are a sum.
std::string joined_terms(const Candidate& candidate, Level level) {
  const bool are_separate =
      level == &ResponseStudy::covariates || candidate.fit.specification.random.size() > 1;
  return fmt::format("{}", fmt::join(candidate.terms, are_separate ? "; " : " + "));
}

}  // namespace

bool ResponseStudy::converged() const {
  if (nlme) return nlme->fit.convergence.converged();
  return !has_groups() && with_covariates && with_covariates->fit.convergence.converged();
}

bool ResponseStudy::has_groups() const {
  constexpr double kFewestTrees = 1.2;  // on average
  return plots >= 2 &&
         static_cast<double>(rows.size()) >= kFewestTrees * static_cast<double>(plots);
}

std::string ResponseStudy::verdict() const {
  if (nlme) return nlme->fit.convergence.verdict();
  if (!ols) return "No base model converged.";
  if (!has_groups()) {
    const std::string why =
        plots < 2 ? fmt::format("There is only one {}",
                                group == "plot" ? "plot" : "value of '" + group + "'")
                  : fmt::format(
                        "There are {} values of '{}' among {} trees, and random effects "
                        "need groups of several trees",
                        plots,
                        group,
                        rows.size());
    return fmt::format(
        "{}: level 3 was skipped. {}", why, with_covariates->fit.convergence.verdict());
  }
  const bool has_objections =
      std::ranges::any_of(random, [](const Candidate& each) { return !each.objection.empty(); });
  return has_objections ? "No mixed model can be used; the least-squares model is final."
                        : "No mixed model converged; the least-squares model is final.";
}

std::vector<std::string> ResponseStudy::rejected() const {
  std::vector<std::string> sentences;
  for (const auto& [level, what] : kLevels) {
    const std::vector<Candidate>& candidates = this->*level;
    std::vector<const Candidate*> passed;
    for (const Candidate& each : candidates) {
      if (!each.objection.empty() && !each.chosen) passed.push_back(&each);
    }
    if (passed.empty()) continue;
    std::ranges::stable_sort(passed, {}, &Candidate::rank);
    const Candidate& first = *passed.front();
    const std::string others =
        passed.size() > 1 ? fmt::format(" and {} more", passed.size() - 1) : std::string();
    sentences.push_back(
        fmt::format("Rejected: {} {}{}. {}", what, name_of(first, level), others, first.objection));
  }
  return sentences;
}

std::vector<std::string> ResponseStudy::remarks() const {
  std::vector<std::string> all = notes;
  for (std::string& sentence : rejected()) all.push_back(std::move(sentence));
  return all;
}

std::string ResponseStudy::chosen_terms(Level level) const {
  const std::vector<Candidate>& candidates = this->*level;
  const auto chosen = std::ranges::find(candidates, true, &Candidate::chosen);
  return chosen == candidates.end() ? std::string() : joined_terms(*chosen, level);
}

std::string name_of(const Candidate& candidate, std::vector<Candidate> ResponseStudy::*level) {
  const fit::FittedModel& fit = candidate.fit;
  if (level == &ResponseStudy::base) {
    return fit.model.empty() ? fit.specification.formula.text : fit.model;
  }
  if (level == &ResponseStudy::variance) return fit.specification.variance.text();
  return candidate.terms.empty() ? "none" : joined_terms(candidate, level);
}

}  // namespace silvafit::study
