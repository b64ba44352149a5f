// SPDX-License-Identifier: MIT
#include "silvafit/study/idle_settings.hpp"

#include <fmt/format.h>

#include "silvafit/base/error.hpp"
#include "silvafit/fit/setting_list.hpp"

namespace silvafit::study {
namespace {

bool is_none(const std::string& text) { return text.empty() || text == "none"; }

/// The method of a fit by its settings, as fit::default_method chooses it by the model.
fit::Method method_of(const fit::ModelTexts& texts, const fit::FitModelOptions& options) {
  if (options.method) return *options.method;
  if (!texts.random.empty()) return fit::Method::kLindstromBates;
  const bool is_plain = is_none(texts.variance) && is_none(texts.correlation) && !options.reml;
  return is_plain ? fit::Method::kOrdinary : fit::Method::kGeneralized;
}

}  // namespace

void refuse_idle(const fit::ModelTexts& texts,
                 const fit::FitModelOptions& options,
                 const GivenName& given_name) {
  using fit::Method;
  IdleReasons idle;
  const Method method = method_of(texts, options);
  if (method != Method::kLindstromBates && method != Method::kGeneralized) {
    idle["maximum_iterations"] = "without `method=lb` or gnls";
  }
  if (texts.random.empty()) idle["starts"] = "without `random`";
  for (const auto& [name, value] : options.start) {
    if (!options.fixed.contains(name)) continue;
    throw UsageError(fmt::format("has no effect on {}, which is held", name),
                     {.column = "`start`"});
  }
  refuse_idle_settings(texts, given_name);
  refuse_idle_settings(options, given_name, idle);
}

}  // namespace silvafit::study
