// SPDX-License-Identifier: MIT
#include "prediction/bent_directions.hpp"

#include <Eigen/QR>
#include <array>
#include <cmath>

#include "silvafit/base/random.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array kMainPlaces{-3.0, -2.0, -1.0, 1.0, 2.0, 3.0};

/// Where gradients are taken, (q x P) in standard deviations: along the main direction, in which a
/// bend far out counts, on both sides in each other one, and at as many places in no special
/// position as span all directions, for what is bent only if several change at once.
MatrixXd places(Index width) {
  const auto main = static_cast<Index>(kMainPlaces.size());
  const Index sides = 2 * (width - 1);
  const Index joint = bend_places(width) - main - sides;
  MatrixXd result = MatrixXd::Zero(width, main + sides + joint);
  for (Index k = 0; k < main; ++k) result(0, k) = kMainPlaces[static_cast<std::size_t>(k)];
  for (Index k = 0; k < sides; ++k) {
    result(1 + k / 2, main + k) = k % 2 == 0 ? std::sqrt(3.0) : -std::sqrt(3.0);
  }
  Random random(1);
  for (double& value : result.rightCols(joint).reshaped()) value = random.normal();
  return result;
}

/// Orthonormal columns that span those of a matrix but for what is shorter than a tolerance.
MatrixXd basis(const MatrixXd& columns, double tolerance) {
  MatrixXd none(columns.rows(), 0);
  if (!(columns.colwise().norm().maxCoeff() > tolerance)) return none;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  Index rank = 0;
  while (rank < qr.matrixR().diagonal().size() && std::abs(qr.matrixR()(rank, rank)) > tolerance) {
    ++rank;
  }
  if (rank == 0) return none;
  return qr.householderQ() * MatrixXd::Identity(columns.rows(), rank);
}

/// \param slope  (q) gradient of the mean in standard deviations
/// \param bends  (q x P) what it changes by from there
BentDirections directions_of(const MatrixXd& root,
                             const VectorXd& slope,
                             const MatrixXd& bends,
                             double tolerance,
                             bool split) {
  if (!bends.allFinite() || !slope.allFinite()) return {.root = root};
  const MatrixXd bent = basis(bends, tolerance);
  const VectorXd within = split ? VectorXd(bent * (bent.transpose() * slope)) : slope;
  const double straight = (slope - within).norm();
  if (!(within.norm() > tolerance)) return {.root = root * bent, .straight = straight};
  const VectorXd main = within.normalized();
  const MatrixXd others = basis(bends - main * (main.transpose() * bends), tolerance);
  MatrixXd result(root.rows(), 1 + others.cols());
  result << root * main, root * others;
  return {.root = result, .straight = straight};
}

}  // namespace

Index bend_places(Index width) {
  if (width == 0) return 0;
  const auto main = static_cast<Index>(kMainPlaces.size());
  return width == 1 ? main : main + 2 * (width - 1) + width + 2;
}

std::vector<BentDirections> bent_directions(const RowMean& mean,
                                            const MatrixXd& center,
                                            const MatrixXd& gradient,
                                            const std::vector<MatrixXd>& roots,
                                            const VectorXd& tolerance,
                                            bool split) {
  Index width = 0;
  for (const MatrixXd& root : roots) width = std::max(width, root.cols());
  std::vector<BentDirections> result;
  if (width == 0) {
    for (const MatrixXd& root : roots) result.push_back({.root = root});
    return result;
  }
  const MatrixXd all = places(width);
  std::vector<MatrixXd> bends;
  bends.reserve(roots.size());
  for (const MatrixXd& root : roots) bends.emplace_back(root.cols(), all.cols());
  for (Index k = 0; k < all.cols(); ++k) {
    MatrixXd at = center;
    for (Index row = 0; row < at.rows(); ++row) {
      const MatrixXd& root = roots[static_cast<std::size_t>(row)];
      at.row(row) += (root * all.col(k).head(root.cols())).transpose();
    }
    const MatrixXd change = mean.gradient(at) - gradient;
    for (Index row = 0; row < at.rows(); ++row) {
      const auto i = static_cast<std::size_t>(row);
      bends[i].col(k) = roots[i].transpose() * change.row(row).transpose();
    }
  }
  for (std::size_t i = 0; i < roots.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const VectorXd slope = roots[i].transpose() * gradient.row(row).transpose();
    result.push_back(directions_of(roots[i], slope, bends[i], tolerance[row], split));
  }
  return result;
}

}  // namespace silvafit::fit
