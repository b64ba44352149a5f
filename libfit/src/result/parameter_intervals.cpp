// SPDX-License-Identifier: MIT
#include "silvafit/fit/parameter_intervals.hpp"

#include <fmt/format.h>

#include "silvafit/base/error.hpp"

namespace silvafit::fit {

IntervalMethod parse_interval_method(std::string_view text) {
  if (text == "wald") return IntervalMethod::kWald;
  if (text == "profile") return IntervalMethod::kProfile;
  throw UsageError(fmt::format("unknown kind of interval '{}'; available: wald, profile", text));
}

std::string interval_method_text(IntervalMethod method) {
  return method == IntervalMethod::kWald ? "wald" : "profile";
}

}  // namespace silvafit::fit
