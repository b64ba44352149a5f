// SPDX-License-Identifier: MIT
#include "fit_inference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace silvafit::cli {
namespace {

std::string limit_text(double value) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0.0 ? "unbounded" : "-unbounded";
  return fmt::format("{:.6g}", value);
}

}  // namespace

void add_inference_options(CLI::App& command, InferenceOptions& options) {
  command
      .add_option("--intervals",
                  options.intervals,
                  "Confidence intervals of all parameters: wald (by standard errors) or profile "
                  "(by the likelihood itself)")
      ->check(CLI::IsMember({"wald", "profile"}));
  command.add_option("--level", options.level, "Level of the intervals (default 0.95)")
      ->check([](const std::string& text) {
        double level = 0.0;
        const bool is_level = CLI::detail::lexical_cast(text, level) && level > 0.0 && level < 1.0;
        return is_level ? std::string() : "must lie between 0 and 1, such as 0.95";
      });
}

void add_inference(const InferenceOptions& options,
                   const data::Table& table,
                   fit::FittedModel& fit) {
  if (options.intervals.empty() || !fit.convergence.converged) return;
  fit.intervals =
      fit::confidence_intervals(fit,
                                table,
                                {.method = fit::parse_interval_method(options.intervals),
                                 .level = options.level,
                                 .threads = options.threads});
}

void print_inference(const fit::FittedModel& fit) {
  if (!fit.intervals) return;
  const fit::Intervals& intervals = *fit.intervals;
  std::size_t width = 13;
  for (const fit::ParameterInterval& one : intervals.parameters) {
    width = std::max(width, one.name.size());
  }
  fmt::print("\n{:g} % intervals, {}, {}\n",
             100.0 * intervals.level,
             intervals.method == fit::IntervalMethod::kWald ? "Wald" : "profile",
             intervals.likelihood);
  fmt::print("{:<{}} {:>12} {:>12} {:>12}\n", "parameter", width, "estimate", "lower", "upper");
  for (const fit::ParameterInterval& one : intervals.parameters) {
    fmt::print("{:<{}} {:>12} {:>12} {:>12}{}{}\n",
               one.name,
               width,
               limit_text(one.estimate),
               limit_text(one.lower),
               limit_text(one.upper),
               one.note.empty() ? "" : "  ",
               one.note);
  }
}

}  // namespace silvafit::cli
