// SPDX-License-Identifier: MIT
#include "silvafit/stand/clark_evans.hpp"

#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "silvafit/data/table.hpp"
#include "units/neighbor_search.hpp"

namespace silvafit::stand {
namespace {

double two_sided(double z) { return boost::math::erfc(std::abs(z) / std::numbers::sqrt2); }

double mean_nearest_m(std::span<const Point> points) {
  std::vector<std::uint32_t> rows(points.size());
  std::iota(rows.begin(), rows.end(), 0U);
  const NeighborSearch search(rows, points, std::less<std::uint32_t>{});
  NeighborSearch::Scratch scratch;
  std::vector<Neighbor> found;
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    search.nearest(i, 1, found, scratch);
    sum += found.front().distance_m;
  }
  return sum / static_cast<double>(points.size());
}

}  // namespace

ClarkEvans clark_evans(std::span<const Point> points, const Window& window) {
  constexpr double kNone = data::kMissing;
  ClarkEvans result{points.size(), kNone, kNone, kNone, kNone, kNone, kNone, kNone};
  if (points.size() < 2) return result;
  const auto n = static_cast<double>(points.size());
  const double area = window.area_m2();
  const double perimeter = window.perimeter_m();
  result.mean_distance_m = mean_nearest_m(points);

  const double expected = 0.5 * std::sqrt(area / n);
  // sqrt((4 - pi) / (4 pi)) / sqrt(n * density)
  const double error =
      std::sqrt((4.0 - std::numbers::pi) / (4.0 * std::numbers::pi)) * std::sqrt(area) / n;
  result.R = result.mean_distance_m / expected;
  result.z = (result.mean_distance_m - expected) / error;
  result.p = two_sided(result.z);

  const double corrected = expected + (0.0514 + 0.0412 / std::sqrt(n)) * perimeter / n;
  const double variance =
      0.0703 * area / (n * n) + 0.037 * perimeter * std::sqrt(area / (n * n * n * n * n));
  result.R_donnelly = result.mean_distance_m / corrected;
  result.z_donnelly = (result.mean_distance_m - corrected) / std::sqrt(variance);
  result.p_donnelly = two_sided(result.z_donnelly);
  return result;
}

}  // namespace silvafit::stand
