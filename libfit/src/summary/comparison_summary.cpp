// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>

#include "silvafit/fit/summary.hpp"
#include "summary/text_lines.hpp"

namespace silvafit::fit {
namespace {

std::string shown(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

void append_fits(std::string& text,
                 const Comparison& comparison,
                 const FitNames& names,
                 std::size_t width) {
  append(text,
         "{:<{}} {:<7} {:>3} {:>14} {:>13} {:>13} {:>13} {:>13} {:>10} {:>7}\n",
         "fit",
         width,
         "method",
         "k",
         "log-likelihood",
         "AIC",
         "AICc",
         "BIC",
         "BIC by groups",
         "difference",
         "weight");
  for (const ComparedFit& one : comparison.fits) {
    const FittedModel& fit = *one.fit;
    append(text,
           "{:<{}} {:<7} {:>3} {:>14.4f} {:>13} {:>13} {:>13} {:>13} {:>10} {:>7}\n",
           names.at(&fit),
           width,
           method_text(fit.method),
           fit.parameter_count > 0 ? fmt::to_string(fit.parameter_count) : "-",
           fit.log_likelihood,
           shown(fit.aic(), "{:.4f}"),
           shown(fit.aicc(), "{:.4f}"),
           shown(fit.bic(), "{:.4f}"),
           shown(fit.bic_groups(), "{:.4f}"),
           shown(one.aic_difference, "{:.4f}"),
           shown(one.akaike_weight, "{:.4f}"));
  }
}

void append_pair(std::string& text,
                 const ComparedPair& pair,
                 const Comparison& comparison,
                 const FitNames& names) {
  const std::string& larger = names.at(comparison.fits[pair.larger].fit);
  const std::string& smaller = names.at(comparison.fits[pair.smaller].fit);
  if (!pair.test) {
    append(text, "{} against {}: not tested, {}\n", larger, smaller, pair.reason);
    return;
  }
  const NestedTest& test = *pair.test;
  append(text,
         "{} against {}: likelihood ratio {:.4f}, df {}, p {:.3g} by chi-squared",
         larger,
         smaller,
         test.statistic,
         test.degrees_of_freedom,
         test.p_chi_squared);
  if (test.reference.weights.size() > 1) {
    append(text, ", {:.3g} by {}", test.p, test.reference.text());
  }
  append(text, "{}{}\n", test.note.empty() ? "" : "; ", test.note);
}

}  // namespace

std::string summary(const Comparison& comparison, const FitNames& names) {
  std::string text;
  std::size_t width = 3;
  for (const ComparedFit& one : comparison.fits) width = std::max(width, names.at(one.fit).size());
  for (const FittedModel* const fit : comparison.failed) {
    width = std::max(width, names.at(fit).size());
  }
  append_fits(text, comparison, names, width);
  if (!comparison.reason.empty()) {
    append(text, "the criteria cannot be compared: {}\n", comparison.reason);
  }
  for (const FittedModel* const fit : comparison.failed) {
    append(text, "not converged: {}\n", names.at(fit));
  }
  text += '\n';
  for (const ComparedPair& pair : comparison.pairs) append_pair(text, pair, comparison, names);
  return text;
}

}  // namespace silvafit::fit
