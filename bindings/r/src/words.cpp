// SPDX-License-Identifier: MIT
#include "words.hpp"

#include <array>
#include <utility>

#include "silvafit/base/error.hpp"

namespace silvafit::r {
namespace {

template <class Value, std::size_t size>
Value parse(std::string_view word,
            const char* argument,
            const std::array<std::pair<std::string_view, Value>, size>& words) {
  std::string known;
  for (const auto& [name, value] : words) {
    if (name == word) return value;
    known += known.empty() ? "" : ", ";
    known += name;
  }
  throw UsageError("unknown value '" + std::string(word) + "'; available: " + known,
                   {.column = argument});
}

}  // namespace

fit::Level parse_level(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, fit::Level>, 4> kWords{
      {{"population", fit::Level::kPopulation},
       {"conditional", fit::Level::kConditional},
       {"calibrated", fit::Level::kCalibrated},
       {"marginal", fit::Level::kMarginal}}};
  return parse(word, "level", kWords);
}

fit::NewGroups parse_new_groups(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, fit::NewGroups>, 4> kWords{
      {{"population", fit::NewGroups::kPopulation},
       {"marginal", fit::NewGroups::kMarginal},
       {"missing", fit::NewGroups::kMissing},
       {"error", fit::NewGroups::kError}}};
  return parse(word, "new_groups", kWords);
}

fit::SeenGroups parse_seen_groups(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, fit::SeenGroups>, 3> kWords{
      {{"fitted", fit::SeenGroups::kFitted},
       {"new", fit::SeenGroups::kNew},
       {"combined", fit::SeenGroups::kCombined}}};
  return parse(word, "seen_groups", kWords);
}

fit::IntervalKind parse_interval_kind(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, fit::IntervalKind>, 2> kWords{
      {{"prediction", fit::IntervalKind::kPrediction},
       {"confidence", fit::IntervalKind::kConfidence}}};
  return parse(word, "interval", kWords);
}

std::string kind_word(fit::ParameterKind kind) {
  switch (kind) {
    case fit::ParameterKind::kFixed:
      return "fixed";
    case fit::ParameterKind::kDeviation:
      return "sd";
    case fit::ParameterKind::kCorrelation:
      return "cor";
    case fit::ParameterKind::kVariance:
      return "variance";
    case fit::ParameterKind::kSigma:
      return "sigma";
  }
  return "fixed";
}

}  // namespace silvafit::r
