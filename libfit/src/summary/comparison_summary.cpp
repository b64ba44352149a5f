// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>

#include "silvafit/fit/summary.hpp"
#include "summary/text_lines.hpp"

namespace silvafit::fit {
namespace {

std::string shown(double value) { return std::isfinite(value) ? decimals(value) : "-"; }

void append_fits(std::string& text, const Comparison& comparison, const FitNames& names) {
  TextTable table(3, {-7, 3, 14, 13, 13, 13, 13, 10, 7});
  table.add({"fit",
             "method",
             "k",
             "log-likelihood",
             "AIC",
             "AICc",
             "BIC",
             "BIC by groups",
             "difference",
             "weight"});
  for (const ComparedFit& one : comparison.fits) {
    const FittedModel& fit = *one.fit;
    table.add({names.at(&fit),
               word_of(fit.method),
               fit.parameter_count > 0 ? fmt::to_string(fit.parameter_count) : "-",
               fmt::format("{:.4f}", fit.log_likelihood),
               shown(fit.aic()),
               shown(fit.aicc()),
               shown(fit.bic()),
               shown(fit.bic_groups()),
               shown(one.aic_difference),
               shown(one.akaike_weight)});
  }
  table.append_to(text);
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
  append_fits(text, comparison, names);
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
