// SPDX-License-Identifier: MIT
#include "study/final_residuals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <utility>

namespace silvafit::study {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The nearest other tree of the plot, by the place in `rows`.
std::vector<std::size_t> nearest_trees(const std::vector<Index>& rows,
                                       const Eigen::MatrixX2d& positions_m) {
  std::vector<std::size_t> nearest(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const double distance = (positions_m.row(rows[i]) - positions_m.row(rows[j])).squaredNorm();
      if (j == i || !(distance < least)) continue;
      least = distance;
      nearest[i] = j;
    }
  }
  return nearest;
}

/// Calls f(distance, squared difference of residuals) for each pair of trees of a plot.
template <typename F>
void for_each_pair(const PlacedResiduals& placed, F f) {
  for (const std::vector<Index>& rows : placed.plots) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double difference = placed.residuals[rows[i]] - placed.residuals[rows[j]];
        f((placed.positions_m.row(rows[i]) - placed.positions_m.row(rows[j])).norm(),
          difference * difference);
      }
    }
  }
}

}  // namespace

const fit::FitResult* final_result(const ResponseStudy& result) {
  if (result.nlme) return &*result.nlme;
  if (result.with_covariates) return &*result.with_covariates;
  return result.ols ? &*result.ols : nullptr;
}

VectorXd standardized_residuals(const ResponseStudy& result,
                                const data::Table& table,
                                const fit::FitResult& final) {
  const std::span<const double> values = table.numbers(result.response);
  VectorXd standardized(final.fitted_conditional.size());
  for (Index i = 0; i < standardized.size(); ++i) {
    const double observed = values[result.rows[final.rows[static_cast<std::size_t>(i)]]];
    standardized[i] = (observed - final.fitted_conditional[i]) / final.residual_sd[i];
  }
  return standardized;
}

PlacedResiduals placed_residuals(const ResponseStudy& result, const data::Table& table) {
  PlacedResiduals placed;
  const fit::FitResult* const final = final_result(result);
  const auto is_number = [&](const char* name) {
    return table.has(name) && table.is_numeric(name);
  };
  if (final == nullptr || !table.has("plot") || !is_number("x") || !is_number("y")) return placed;
  placed.residuals = standardized_residuals(result, table, *final);
  placed.positions_m.resize(placed.residuals.size(), 2);
  const data::TextColumn plots = table.labels("plot");
  const data::TextColumn times = result.period.empty() ? plots : table.labels(result.period);
  std::map<std::pair<std::string, std::string>, std::vector<Index>> trees_of;
  for (Index i = 0; i < placed.residuals.size(); ++i) {
    const std::size_t row = result.rows[final->rows[static_cast<std::size_t>(i)]];
    placed.positions_m.row(i) << table.numbers("x")[row], table.numbers("y")[row];
    const bool is_known = placed.positions_m.row(i).allFinite() &&
                          std::isfinite(placed.residuals[i]) && !plots.is_missing(row);
    if (is_known) trees_of[{std::string(plots[row]), std::string(times[row])}].push_back(i);
  }
  constexpr std::size_t kMostTrees = 3000;
  for (auto& [labels, rows] : trees_of) {
    if (rows.size() > 1 && rows.size() <= kMostTrees) placed.plots.push_back(std::move(rows));
  }
  return placed;
}

NeighborCorrelation neighbor_correlation(const PlacedResiduals& placed) {
  double sum = 0.0;       // of products, each pair of mutual neighbors twice
  double squares = 0.0;   // of the residuals of trees with a neighbor
  double variance = 0.0;  // of the sum if residuals are independent with variance 1
  for (const std::vector<Index>& rows : placed.plots) {
    const std::vector<std::size_t> nearest = nearest_trees(rows, placed.positions_m);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      sum += placed.residuals[rows[i]] * placed.residuals[rows[nearest[i]]];
      squares += placed.residuals[rows[i]] * placed.residuals[rows[i]];
      // A mutual pair has the weight 2 and is met twice.
      variance += nearest[nearest[i]] == i ? 2.0 : 1.0;
    }
  }
  if (!(squares > 0.0)) return {};
  return {.correlation = sum / squares, .z = sum / std::sqrt(variance)};
}

std::vector<VariogramClass> residual_variogram(const PlacedResiduals& placed) {
  constexpr std::size_t kClasses = 10;
  constexpr std::size_t kFewestPairs = 30;
  double farthest_m = 0.0;
  for_each_pair(placed, [&](double distance_m, double /*squared*/) {
    farthest_m = std::max(farthest_m, distance_m);
  });
  if (!(farthest_m > 0.0)) return {};
  std::array<VariogramClass, kClasses> classes{};
  const double width_m = 0.5 * farthest_m / kClasses;
  for_each_pair(placed, [&](double distance_m, double squared) {
    const auto k = static_cast<std::size_t>(distance_m / width_m);
    if (k >= kClasses) return;
    classes[k].distance_m += distance_m;
    classes[k].semivariance += 0.5 * squared;
    ++classes[k].pairs;
  });
  std::vector<VariogramClass> filled;
  for (const VariogramClass& sums : classes) {
    if (sums.pairs < kFewestPairs) continue;
    const auto pairs = static_cast<double>(sums.pairs);
    filled.push_back({sums.distance_m / pairs, sums.semivariance / pairs, sums.pairs});
  }
  return filled;
}

}  // namespace silvafit::study
