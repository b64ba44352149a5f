// SPDX-License-Identifier: MIT
#include "silvafit/tree/ifs.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

Eigen::Matrix3d matrix_of(const AffineMap& map) {
  Eigen::Matrix3d a;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) a(row, column) = map.a[row][column];
  }
  return a;
}

bool is_finite(const AffineMap& map) {
  return matrix_of(map).allFinite() && std::isfinite(map.b.x) && std::isfinite(map.b.y) &&
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

/// The point that a map leaves where it is.
Point fixed_point(const AffineMap& map) {
  const Eigen::Vector3d b(map.b.x, map.b.y, map.b.z);
  const Eigen::Vector3d x = (Eigen::Matrix3d::Identity() - matrix_of(map)).partialPivLu().solve(b);
  return {x(0), x(1), x(2)};
}

}  // namespace

Point AffineMap::turn(Point x) const {
  return {a[0][0] * x.x + a[0][1] * x.y + a[0][2] * x.z,
          a[1][0] * x.x + a[1][1] * x.y + a[1][2] * x.z,
          a[2][0] * x.x + a[2][1] * x.y + a[2][2] * x.z};
}

Point AffineMap::operator()(Point x) const { return turn(x) + b; }

AffineMap AffineMap::after(const AffineMap& first) const {
  AffineMap both;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      both.a[row][column] = a[row][0] * first.a[0][column] + a[row][1] * first.a[1][column] +
                            a[row][2] * first.a[2][column];
    }
  }
  both.b = (*this)(first.b);
  return both;
}

AffineMap turn_about(Point axis, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  const double d = 1.0 - c;
  const Point n = direction(axis);
  return {.a = {{{c + d * n.x * n.x, d * n.x * n.y - s * n.z, d * n.x * n.z + s * n.y},
                 {d * n.y * n.x + s * n.z, c + d * n.y * n.y, d * n.y * n.z - s * n.x},
                 {d * n.z * n.x - s * n.y, d * n.z * n.y + s * n.x, c + d * n.z * n.z}}}};
}

AffineMap scaled(const AffineMap& map, double factor) {
  AffineMap result = map;
  for (auto& row : result.a) {
    for (double& value : row) value *= factor;
  }
  return result;
}

double AffineMap::determinant() const { return matrix_of(*this).determinant(); }

double AffineMap::spectral_norm() const {
  return Eigen::JacobiSVD<Eigen::Matrix3d>(matrix_of(*this)).singularValues()(0);
}

IteratedFunctionSystem::IteratedFunctionSystem(std::vector<AffineMap> maps,
                                               std::vector<double> probabilities)
    : maps_(std::move(maps)), probabilities_(std::move(probabilities)) {
  if (maps_.empty()) throw DomainError("an iterated function system needs a map");
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (!is_finite(maps_[i]) || !(maps_[i].spectral_norm() < 1.0)) {
      throw DomainError("map " + std::to_string(i + 1) +
                        " does not shrink space: its largest singular value must be below 1");
    }
  }
  if (probabilities_.empty()) probabilities_ = by_volume(maps_);
  if (probabilities_.size() != maps_.size()) {
    throw DomainError("either each map has a probability or none");
  }
  double sum = 0.0;
  for (const double probability : probabilities_) {
    if (!(probability > 0.0)) throw DomainError("a map's probability must be above 0");
    sum += probability;
    cumulative_.push_back(sum);
  }
  constexpr double kRounding = 1e-9;
  if (!(std::abs(sum - 1.0) <= kRounding)) {
    throw DomainError("the maps' probabilities must add up to 1, not " + std::to_string(sum));
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
  // The sum falls in D, from the number of maps at 0.
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
