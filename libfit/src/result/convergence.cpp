// SPDX-License-Identifier: MIT
#include "silvafit/fit/convergence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "silvafit/data/table.hpp"

namespace silvafit::fit {
namespace {

using EvidenceKind = Evidence::Kind;

struct StatusTexts {
  std::string_view name;
  std::string_view phrase;
};

/// In the order of the enumeration.
constexpr std::array<StatusTexts, 15> kStatus{{
    {"converged", "converged"},
    {"boundary", "boundary (singular) fit"},
    {"perfect_fit", "perfect fit"},
    {"published", "published model"},
    {"not_identifiable", "not identifiable"},
    {"no_maximum", "no maximum of the likelihood"},
    {"contained_model_higher", "a contained model has a higher log-likelihood"},
    {"invalid_approximation", "the approximation of the likelihood is not valid"},
    {"diverged", "the search diverged"},
    {"iteration_limit", "the iteration limit was reached"},
    {"maximum_not_reached", "no maximum was reached"},
    {"no_start_values", "no start values"},
    {"too_few_observations", "too few observations"},
    {"outside_bounds", "no fit within the bounds"},
    {"unknown", "not converged"},
}};
constexpr std::array<std::string_view, 16> kKindNames{"boundary",
                                                      "lower_bound",
                                                      "upper_bound",
                                                      "not_identifiable",
                                                      "hardly_identifiable",
                                                      "unbounded",
                                                      "moving",
                                                      "contained_model",
                                                      "marginal_log_likelihood",
                                                      "marginal_maximum",
                                                      "higher_end",
                                                      "other_optimum",
                                                      "floored_values",
                                                      "power_of_few",
                                                      "taken_as_parameter",
                                                      "response_values"};

bool explains_failure(EvidenceKind kind) {
  return kind == EvidenceKind::kNotIdentifiable || kind == EvidenceKind::kHardlyIdentifiable ||
         kind == EvidenceKind::kUnbounded || kind == EvidenceKind::kContainedModel;
}

bool is_boundary(const Evidence& evidence) {
  return evidence.kind == EvidenceKind::kBoundary || evidence.kind == EvidenceKind::kLowerBound ||
         evidence.kind == EvidenceKind::kUpperBound;
}

}  // namespace

std::string_view status_text(ConvergenceStatus status) {
  return kStatus[static_cast<std::size_t>(status)].name;
}

ConvergenceStatus parse_status(std::string_view text) {
  const auto* const found = std::ranges::find(kStatus, text, &StatusTexts::name);
  return found == kStatus.end() ? ConvergenceStatus::kUnknown
                                : static_cast<ConvergenceStatus>(found - kStatus.begin());
}

std::string_view kind_text(EvidenceKind kind) { return kKindNames[static_cast<std::size_t>(kind)]; }

std::optional<EvidenceKind> parse_kind(std::string_view text) {
  const auto* const found = std::ranges::find(kKindNames, text);
  if (found == kKindNames.end()) return std::nullopt;
  return static_cast<EvidenceKind>(found - kKindNames.begin());
}

std::string text_of(const Evidence& evidence) {
  if (std::isnan(evidence.value)) return evidence.term;
  std::string result = evidence.term + " = " + data::shortest(evidence.value);
  if (evidence.kind == EvidenceKind::kLowerBound) return result + ", its lower bound";
  if (evidence.kind == EvidenceKind::kUpperBound) return result + ", its upper bound";
  return result;
}

void Convergence::conclude(ConvergenceStatus found,
                           Finding reason,
                           std::optional<EvidenceKind> named) {
  status = found;
  if (named) add(*named, reason.names);
  findings = {std::move(reason)};
}

bool Convergence::converged() const {
  return status == ConvergenceStatus::kConverged || status == ConvergenceStatus::kBoundary ||
         status == ConvergenceStatus::kPerfectFit || status == ConvergenceStatus::kPublished;
}

std::vector<std::string> Convergence::boundary() const {
  std::vector<std::string> result;
  for (const Evidence& item : evidence) {
    if (is_boundary(item)) result.push_back(text_of(item));
  }
  return result;
}

bool Convergence::has_boundary() const { return std::ranges::any_of(evidence, is_boundary); }

std::string Convergence::summary() const {
  std::string result(kStatus[static_cast<std::size_t>(status)].phrase);
  const char* separator = ": ";
  for (const Evidence& item : evidence) {
    if (!explains_failure(item.kind)) continue;
    result += separator + item.term;
    separator = ", ";
  }
  return result;
}

bool Convergence::has(EvidenceKind kind, std::string_view term) const {
  return std::ranges::any_of(
      evidence, [&](const Evidence& item) { return item.kind == kind && item.term == term; });
}

void Convergence::add(EvidenceKind kind, const std::vector<std::string>& terms) {
  for (const std::string& term : terms) evidence.push_back({.kind = kind, .term = term});
}

bool Convergence::has_doubts() const {
  return std::ranges::any_of(evidence, [](const Evidence& item) {
    return item.kind == EvidenceKind::kTakenAsParameter ||
           item.kind == EvidenceKind::kResponseValues;
  });
}

void Convergence::add_boundary(Evidence item) {
  if (status == ConvergenceStatus::kConverged) status = ConvergenceStatus::kBoundary;
  evidence.push_back(std::move(item));
}

}  // namespace silvafit::fit
