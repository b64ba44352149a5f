// SPDX-License-Identifier: MIT
#include "simulation/covariance_root.hpp"

#include <cmath>

namespace silvafit::study {

std::optional<Eigen::MatrixXd> covariance_root(const Eigen::MatrixXd& covariance) {
  constexpr double kTolerance = 1e-10;
  const Eigen::Index size = covariance.rows();
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    double pivot = covariance(j, j);
    for (Eigen::Index k = 0; k < j; ++k) pivot -= root(j, k) * root(j, k);
    if (!(pivot >= -kTolerance * covariance(j, j))) return std::nullopt;
    const bool is_singular = pivot <= kTolerance * covariance(j, j);
    root(j, j) = is_singular ? 0.0 : std::sqrt(pivot);
    for (Eigen::Index i = j + 1; i < size; ++i) {
      double rest = covariance(i, j);
      for (Eigen::Index k = 0; k < j; ++k) rest -= root(i, k) * root(j, k);
      if (!is_singular) {
        root(i, j) = rest / root(j, j);
        continue;
      }
      // Effect j has no variance left, so its covariances must be 0, too. The bound
      // is that of a pivot at the tolerance: |rest| <= sqrt(pivot_i pivot_j).
      const double largest = std::sqrt(kTolerance * covariance(i, i) * covariance(j, j));
      if (std::abs(rest) > largest) return std::nullopt;
    }
  }
  return root;
}

}  // namespace silvafit::study
