// SPDX-License-Identifier: MIT
#include "fit_inference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/fit/conditional_errors.hpp"
#include "silvafit/fit/intervals.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

std::string limit_text(double value) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0.0 ? "unbounded" : "-unbounded";
  return fmt::format("{:.6g}", value);
}

/// Groups that fit on a screen; `--json` has them all.
constexpr std::size_t kMostGroups = 40;

void print_effects(const std::string& group, const fit::EstimatedEffects& term) {
  if (!term.uncertainty.is_known() || term.labels.size() > kMostGroups) return;
  const Eigen::MatrixXd errors = fit::conditional_errors(term.uncertainty, term.effects.rows());
  std::size_t width = std::max<std::size_t>(13, group.size());
  for (const std::string& label : term.labels) width = std::max(width, label.size());
  print_text("\n{:<{}}", group, width);
  for (const std::string& name : term.names) print_text(" {:>12} {:>12}", name, "std. error");
  print_text("\n");
  for (std::size_t g = 0; g < term.labels.size(); ++g) {
    print_text("{:<{}}", term.labels[g], width);
    for (Eigen::Index k = 0; k < term.effects.rows(); ++k) {
      const auto at = static_cast<Eigen::Index>(g);
      print_text(" {:>12.5g} {:>12.5g}", term.effects(k, at), errors(k, at));
    }
    print_text("\n");
  }
}

void print_all_effects(const fit::FittedModel& fit) {
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    print_effects(fit.specification.random[k].group, fit.random[k]);
  }
}

}  // namespace

void add_inference_options(CLI::App& command, InferenceOptions& options) {
  command
      .add_option("--intervals",
                  options.intervals,
                  "Confidence intervals of all parameters: wald (from standard errors) or profile "
                  "(from the profile likelihood)")
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
  if (options.intervals.empty() || !fit.convergence.converged()) return;
  fit.intervals =
      fit::confidence_intervals(fit,
                                table,
                                {.method = fit::parse_interval_method(options.intervals),
                                 .level = options.level,
                                 .threads = options.threads});
}

void print_inference(const fit::FittedModel& fit) {
  print_all_effects(fit);
  if (!fit.intervals) return;
  const fit::Intervals& intervals = *fit.intervals;
  std::size_t width = 13;
  for (const fit::ParameterInterval& one : intervals.parameters) {
    width = std::max(width, one.name.size());
  }
  print_text("\n{:g} % intervals, {}, {}\n",
             100.0 * intervals.level,
             intervals.method == fit::IntervalMethod::kWald ? "Wald" : "profile",
             intervals.likelihood);
  print_text("{:<{}} {:>12} {:>12} {:>12}\n", "parameter", width, "estimate", "lower", "upper");
  for (const fit::ParameterInterval& one : intervals.parameters) {
    print_text("{:<{}} {:>12} {:>12} {:>12}{}{}\n",
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
