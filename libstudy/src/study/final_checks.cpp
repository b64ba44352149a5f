// SPDX-License-Identifier: MIT
#include "study/final_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "silvafit/base/text.hpp"
#include "study/outlying_plots.hpp"
#include "study/outlying_trees.hpp"

namespace silvafit::study {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The result of the last level that chose a model; none if no level did.
const fit::FitResult* final_result(const ResponseStudy& result) {
  if (result.nlme) return &*result.nlme;
  if (result.with_covariates) return &*result.with_covariates;
  return result.ols ? &*result.ols : nullptr;
}

/// AIC of a constant, from the least-squares fit to the same trees.
double aic_of_mean(const fit::FittedModel& ols) {
  constexpr double kParameters = 2.0;
  const auto n = static_cast<double>(ols.observations);
  return 2.0 * kParameters - 2.0 * ols.log_likelihood - n * std::log1p(-ols.population.r2);
}

/// A curve can be plausible and still not explain the response.
void doubt_useless_curve(ResponseStudy& result) {
  if (!result.ols || !result.ols->fit.convergence.converged()) return;
  const fit::FittedModel& ols = result.ols->fit;
  const fit::FittedModel& final = final_result(result)->fit;
  if (std::isnan(ols.population.r2)) {
    result.doubts.push_back("All values are equal, so that there is nothing to explain.");
  } else if (aic_of_mean(ols) < final.aic()) {
    result.doubts.push_back(
        fmt::format("The mean of the trees describes them better than this model (AIC {:.1f} "
                    "against {:.1f}). "
                    "Use the mean.",
                    aic_of_mean(ols),
                    final.aic()));
  }
}

/// "tree 12 of plot 3 (line 45: 182 instead of about 19 m)"
std::string tree_text(const ResponseStudy& result,
                      const data::Table& table,
                      const fit::FitResult& final,
                      Index observation) {
  const std::size_t row = result.rows[final.rows[static_cast<std::size_t>(observation)]];
  std::string name;
  for (const char* const column : {"tree", "plot"}) {
    if (!table.has(column)) continue;
    name += fmt::format("{}{} {}", name.empty() ? "" : " of ", column, table.labels(column)[row]);
  }
  const std::string line = table.line(row) > 0 ? fmt::format("line {}", table.line(row)) : "";
  if (name.empty()) name = line.empty() ? fmt::format("row {}", row + 1) : line;
  return fmt::format("{} ({}{:.4g} instead of about {:.3g} {})",
                     name,
                     line.empty() || name == line ? "" : line + ": ",
                     table.numbers(result.response)[row],
                     final.fitted_conditional[observation],
                     unit_of(result.response));
}

std::string outlying_trees_sentence(const ResponseStudy& result,
                                    const data::Table& table,
                                    const fit::FitResult& final,
                                    const OutlyingTrees& outlying) {
  constexpr std::size_t kNamed = 5;
  const std::size_t count = outlying.observations.size();
  std::vector<std::string> names;
  for (std::size_t k = 0; k < std::min(kNamed, count); ++k) {
    names.push_back(tree_text(result, table, final, outlying.observations[k]));
  }
  if (count > kNamed) names.push_back(fmt::format("and {} more", count - kNamed));
  return fmt::format(
      "Outlying {}: {}. The residuals are {} times as large as usual ones or larger. Check the "
      "measurements.",
      count > 1 ? "trees" : "tree",
      fmt::join(names, ", "),
      std::floor(outlying.distances.back()));
}

/// A few wrong values can determine the curve and the residual variance.
void check_outlying_trees(ResponseStudy& result, const data::Table& table) {
  const fit::FitResult* const final = final_result(result);
  if (final == nullptr) return;
  const std::span<const double> values = table.numbers(result.response);
  VectorXd standardized(final->fitted_conditional.size());
  for (Index i = 0; i < standardized.size(); ++i) {
    const double observed = values[result.rows[final->rows[static_cast<std::size_t>(i)]]];
    standardized[i] = (observed - final->fitted_conditional[i]) / final->residual_sd[i];
  }
  const OutlyingTrees outlying = outlying_trees(standardized);
  if (outlying.observations.empty()) return;
  const std::string sentence = outlying_trees_sentence(result, table, *final, outlying);
  constexpr double kMostVariance = 0.5;
  if (outlying.share > kMostVariance) {
    result.doubts.push_back(
        fmt::format("{} of {} {} up {:.0f} % of the residual variance. {}",
                    outlying.observations.size(),
                    counted(static_cast<std::size_t>(standardized.size()), "tree", "trees"),
                    outlying.observations.size() == 1 ? "makes" : "make",
                    100.0 * outlying.share,
                    sentence));
  } else {
    result.notes.push_back(sentence);
  }
}

/// Outlying plots, which the user should check before using the variances.
void note_outlying_plots(ResponseStudy& result) {
  if (!result.nlme) return;
  const std::string note = outlying_sentence(outlying_plots(result.nlme->fit), result.group);
  if (!note.empty()) result.notes.push_back(note);
}

}  // namespace

void check_final_model(ResponseStudy& result, const data::Table& table) {
  doubt_useless_curve(result);
  check_outlying_trees(result, table);
  note_outlying_plots(result);
}

}  // namespace silvafit::study
