// SPDX-License-Identifier: MIT
#include "silvafit/tree/ifs.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "segments/linear_part.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

bool is_finite(const AffineMap& map) {
  return linear_part(map).allFinite() && std::isfinite(map.b.x) && std::isfinite(map.b.y) &&
         std::isfinite(map.b.z);
}

std::vector<double> by_volume(const std::vector<AffineMap>& maps) {
  constexpr double kFlat = 0.001;
  std::vector<double> probabilities;
  double sum = 0.0;
  for (const AffineMap& map : maps) {
    probabilities.push_back(std::max(std::abs(map.determinant()), kFlat));
    sum += probabilities.back();
  }
  for (double& probability : probabilities) probability /= sum;
  return probabilities;
}

/// The fixed point of a map.
Point fixed_point(const AffineMap& map) {
  const Eigen::Vector3d b(map.b.x, map.b.y, map.b.z);
  const Eigen::Vector3d x =
      (Eigen::Matrix3d::Identity() - linear_part(map)).partialPivLu().solve(b);
  return {x(0), x(1), x(2)};
}

}  // namespace

IteratedFunctionSystem::IteratedFunctionSystem(std::vector<AffineMap> maps,
                                               std::vector<double> probabilities)
    : maps_(std::move(maps)), probabilities_(std::move(probabilities)) {
  if (maps_.empty()) throw DomainError("an iterated function system needs at least one map");
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (!is_finite(maps_[i]) || !(maps_[i].spectral_norm() < 1.0)) {
      throw DomainError("map " + std::to_string(i + 1) +
                        " is not contractive: its largest singular value must be below 1");
    }
  }
  if (probabilities_.empty()) probabilities_ = by_volume(maps_);
  if (probabilities_.size() != maps_.size()) {
    throw DomainError("give a probability for every map or for none");
  }
  double sum = 0.0;
  for (const double probability : probabilities_) {
    if (!(probability > 0.0)) throw DomainError("a map's probability must be above 0");
    sum += probability;
    cumulative_.push_back(sum);
  }
  constexpr double kRounding = 1e-9;
  if (!(std::abs(sum - 1.0) <= kRounding)) {
    throw DomainError("the probabilities of the maps must sum to 1, not " + std::to_string(sum));
  }
}

std::size_t IteratedFunctionSystem::drawn(double uniform) const {
  const auto above = std::upper_bound(cumulative_.begin(), cumulative_.end(), uniform);
  return std::min(static_cast<std::size_t>(above - cumulative_.begin()), maps_.size() - 1);
}

std::vector<Point> IteratedFunctionSystem::chaos_game(std::size_t count, Random& random) const {
  constexpr int kForgotten = 64;
  Point at = fixed_point(maps_.front());
  for (int i = 0; i < kForgotten; ++i) at = maps_[drawn(random.uniform())](at);
  std::vector<Point> points;
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    at = maps_[drawn(random.uniform())](at);
    points.push_back(at);
  }
  return points;
}

double IteratedFunctionSystem::similarity_dimension() const {
  std::vector<double> scales;
  for (const AffineMap& map : maps_) scales.push_back(std::cbrt(std::abs(map.determinant())));
  const auto sum = [&scales](double dimension) {
    double total = 0.0;
    for (const double scale : scales) total += scale > 0.0 ? std::pow(scale, dimension) : 0.0;
    return total;
  };
  // The sum decreases with D, from the number of maps at 0.
  double low = 0.0;
  double high = 1.0;
  while (sum(high) > 1.0) high *= 2.0;
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (sum(middle) > 1.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace silvafit::tree
