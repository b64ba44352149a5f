// SPDX-License-Identifier: MIT
#include "result/intervals_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/fit/fit_json.hpp"

namespace silvafit::fit {
namespace {

using data::JsonReader;
using nlohmann::ordered_json;

// The meanings of null.
constexpr std::string_view kUnbounded = "unbounded";
constexpr std::string_view kUnknown = "unknown";

/// A limit, and a separate key with the meaning of null.
void add_limit(const std::string& key, double value, ordered_json& target) {
  target[key] = number_or_null(value);
  if (!std::isfinite(value)) target[key + "_is"] = std::isinf(value) ? kUnbounded : kUnknown;
}

double read_limit(const JsonReader& json, const std::string& key, double infinite) {
  const bool is_unbounded = json.has(key + "_is") && json.at(key + "_is").text() == kUnbounded;
  return is_unbounded ? infinite : json.at(key).number_or_missing();
}

}  // namespace

ordered_json statistics_json(const FitStatistics& values) {
  return {{"r2", number_or_null(values.r2)},
          {"mean_error", number_or_null(values.mean_error)},
          {"rmse", number_or_null(values.rmse)},
          {"mae", number_or_null(values.mae)}};
}

ordered_json intervals_json(const Intervals& intervals) {
  ordered_json parameters = ordered_json::object();
  for (const ParameterInterval& one : intervals.parameters) {
    ordered_json& target = parameters[one.name];
    target["kind"] = word_of(one.kind);
    add_limit("estimate", one.estimate, target);
    add_limit("lower", one.lower, target);
    add_limit("upper", one.upper, target);
    if (!one.note.empty()) target["note"] = one.note;
  }
  return {{"method", word_of(intervals.method)},
          {"level", intervals.level},
          {"likelihood", intervals.likelihood},
          {"parameters", std::move(parameters)}};
}

Intervals read_intervals(const JsonReader& json) {
  Intervals result{.level = json.at("level").number_or_missing(),
                   .likelihood = json.at("likelihood").any_text()};
  result.method = json.at("method").word<IntervalMethod>();
  for (const auto& [name, value] : json.at("parameters").members()) {
    result.parameters.push_back({.kind = value.at("kind").word<ParameterKind>(),
                                 .name = name,
                                 .estimate = read_limit(value, "estimate", kInfinity),
                                 .lower = read_limit(value, "lower", -kInfinity),
                                 .upper = read_limit(value, "upper", kInfinity),
                                 .note = value.has("note") ? value.at("note").any_text() : ""});
  }
  return result;
}

}  // namespace silvafit::fit
