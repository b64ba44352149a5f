// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "silvafit/base/text.hpp"
#include "study/final_residuals.hpp"
#include "study/outliers.hpp"
#include "study/study_work.hpp"

namespace silvafit::study {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

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

/// Neighbors that are alike make standard errors too small.
void check_neighbors(ResponseStudy& result, const data::Table& table) {
  const PlacedResiduals placed = placed_residuals(result, table);
  result.variogram = residual_variogram(placed);
  const NeighborCorrelation found = neighbor_correlation(placed);
  constexpr double kNotable = 0.1;
  constexpr double kQuantile = 3.3;  // one-sided p of 0.0005
  if (found.correlation < kNotable || found.z < kQuantile) return;
  result.notes.push_back(fmt::format(
      "Residuals of trees and their nearest neighbors are correlated ({:.2f}), so that standard "
      "errors are too small. Fit the model with a `correlation` such as exponential(x, y).",
      found.correlation));
}

/// A few wrong values can determine the curve and the residual variance.
void check_outlying_trees(ResponseStudy& result, const data::Table& table) {
  const fit::FitResult* const final = final_result(result);
  if (final == nullptr) return;
  const VectorXd standardized = standardized_residuals(result, table, *final);
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

bool is_constant_within(const std::string& column,
                        const data::Table& table,
                        const ResponseStudy& result) {
  const data::TextColumn groups = table.labels(result.group);
  const auto values = table.numbers(column);
  std::map<std::uint32_t, double> value_of;
  return std::ranges::all_of(result.rows, [&](std::size_t row) {
    return value_of.try_emplace(groups.code(row), values[row]).first->second == values[row];
  });
}

/// Level 2 takes trees as independent, of which a covariate with one value in each plot has too few
/// to be tested so: the test of the mixed model holds.
void doubt_covariates_of_plots(ResponseStudy& result,
                               const data::Table& table,
                               double significance) {
  if (!result.nlme || !table.has(result.group)) return;
  const fit::FittedModel& fit = result.nlme->fit;
  const VectorXd p = fit.p_values();
  std::set<std::string> doubtful;
  for (const fit::ParameterModel& parameter : fit.specification.parameters) {
    for (const fit::Covariate& covariate : parameter.covariates) {
      const auto name =
          std::ranges::find(fit.coefficient_names, parameter.coefficient_name(covariate));
      const bool is_column = table.has(covariate.label) && table.is_numeric(covariate.label);
      if (!is_column || name == fit.coefficient_names.end()) continue;
      const double own = p[name - fit.coefficient_names.begin()];
      if (!(own > significance) || !is_constant_within(covariate.label, table, result)) continue;
      doubtful.insert(fmt::format("{} (p = {:.2g})", covariate.label, own));
    }
  }
  if (doubtful.empty()) return;
  result.doubts.push_back(
      fmt::format("Covariates with one value in each {} were chosen as if trees were independent, "
                  "and are not significant in the mixed model: {}. Leave them out.",
                  result.group,
                  fmt::join(doubtful, ", ")));
}

}  // namespace

void check_final_model(ResponseStudy& result, const data::Table& table, double significance) {
  doubt_covariates_of_plots(result, table, significance);
  doubt_useless_curve(result);
  check_outlying_trees(result, table);
  note_outlying_plots(result);
  check_neighbors(result, table);
}

}  // namespace silvafit::study
