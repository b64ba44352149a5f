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

/// The status in words, in the order of the enumeration.
constexpr std::array<std::string_view, 15> kPhrases{
    "converged",
    "boundary (singular) fit",
    "perfect fit",
    "published model",
    "not identifiable",
    "no maximum of the likelihood",
    "a contained model has a higher log-likelihood",
    "the approximation of the likelihood is not valid",
    "the search diverged",
    "the iteration limit was reached",
    "no maximum was reached",
    "no start values",
    "too few observations",
    "no fit within the bounds",
    "not converged",
};
bool explains_failure(EvidenceKind kind) {
  return kind == EvidenceKind::kNotIdentifiable || kind == EvidenceKind::kHardlyIdentifiable ||
         kind == EvidenceKind::kUnbounded || kind == EvidenceKind::kContainedModel;
}

bool is_boundary(const Evidence& evidence) {
  return evidence.kind == EvidenceKind::kBoundary || evidence.kind == EvidenceKind::kLowerBound ||
         evidence.kind == EvidenceKind::kUpperBound;
}

}  // namespace

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
  std::string result(kPhrases[static_cast<std::size_t>(status)]);
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
           item.kind == EvidenceKind::kResponseValues || item.kind == EvidenceKind::kMissingCode;
  });
}

void Convergence::find_kinks() {
  Finding found{.kind = Finding::Kind::kAtKink};
  for (const Evidence& item : evidence) {
    if (item.kind == EvidenceKind::kKink) found.names.push_back(item.term);
  }
  if (!found.names.empty()) find(std::move(found));
}

void Convergence::add_boundary(Evidence item) {
  if (status == ConvergenceStatus::kConverged) status = ConvergenceStatus::kBoundary;
  evidence.push_back(std::move(item));
}

}  // namespace silvafit::fit
