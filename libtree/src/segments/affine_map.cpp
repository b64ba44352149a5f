// SPDX-License-Identifier: MIT
#include "segments/affine_map.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace silvafit::tree {
namespace {

Eigen::Matrix3d linear_part(const AffineMap& map) {
  Eigen::Matrix3d a;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) a(row, column) = map.a[row][column];
  }
  return a;
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

double AffineMap::determinant() const { return linear_part(*this).determinant(); }

double AffineMap::spectral_norm() const {
  return Eigen::JacobiSVD<Eigen::Matrix3d>(linear_part(*this)).singularValues()(0);
}

}  // namespace silvafit::tree
