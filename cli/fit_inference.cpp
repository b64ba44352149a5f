// SPDX-License-Identifier: MIT
#include "fit_inference.hpp"

#include <string>

#include "silvafit/fit/intervals.hpp"

namespace silvafit::cli {
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

}  // namespace silvafit::cli
