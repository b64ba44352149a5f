// SPDX-License-Identifier: MIT
#include "prediction/nonlinear_directions.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "silvafit/base/random.hpp"

namespace silvafit::fit {
namespace {

constexpr std::array kMainProbes{-3.0, -2.0, -1.0, 1.0, 2.0, 3.0};

/// The points of the gradients, (q x P) in standard deviations: along the main direction up to 3,
/// on both sides in each other one, and at random points that span all directions, for means that
/// are nonlinear only if several arguments change together.
MatrixXd probes(Index width) {
  const auto main = static_cast<Index>(kMainProbes.size());
  const Index sides = 2 * (width - 1);
  const Index joint = probe_count(width) - main - sides;
  MatrixXd result = MatrixXd::Zero(width, main + sides + joint);
  for (Index k = 0; k < main; ++k) result(0, k) = kMainProbes[static_cast<std::size_t>(k)];
  for (Index k = 0; k < sides; ++k) {
    result(1 + k / 2, main + k) = k % 2 == 0 ? std::sqrt(3.0) : -std::sqrt(3.0);
  }
  Random random(1);
  for (double& value : result.rightCols(joint).reshaped()) value = random.normal();
  return result;
}

/// Of so few directions, matrices need no memory from the heap, which would take most of the time.
constexpr Index kFewDirections = 6;
using FewRows =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kFewDirections, 24>;

/// Orthonormal columns that span those of a matrix, without parts shorter than a tolerance.
template <typename Matrix>
Matrix basis(const Matrix& columns, double tolerance) {
  Matrix none(columns.rows(), 0);
  if (!(columns.colwise().norm().maxCoeff() > tolerance)) return none;
  const Eigen::ColPivHouseholderQR<Matrix> qr(columns);
  Index rank = 0;
  while (rank < qr.matrixR().diagonal().size() && std::abs(qr.matrixR()(rank, rank)) > tolerance) {
    ++rank;
  }
  if (rank == 0) return none;
  return qr.householderQ() * Matrix::Identity(columns.rows(), rank);
}

/// \param slope  (q) gradient of the mean in standard deviations
/// \param changes  (q x P) its changes from there to the probes
template <typename Matrix>
NonlinearDirections directions_of(const MatrixXd& root,
                                  const VectorXd& slope,
                                  const Matrix& changes,
                                  double tolerance,
                                  bool split) {
  if (!changes.allFinite() || !slope.allFinite()) return {.root = root};
  const Matrix nonlinear = basis<Matrix>(changes, tolerance);
  const VectorXd within = split ? VectorXd(nonlinear * (nonlinear.transpose() * slope)) : slope;
  const double linear = (slope - within).norm();
  if (!(within.norm() > tolerance)) return {.root = root * nonlinear, .linear = linear};
  const VectorXd main = within.normalized();
  const Matrix others = basis<Matrix>(changes - main * (main.transpose() * changes), tolerance);
  MatrixXd result(root.rows(), 1 + others.cols());
  result << root * main, root * others;
  return {.root = result, .linear = linear};
}

/// \param all  (q x P) probes
template <typename Matrix>
void directions_from(const RowMean& mean,
                     const MatrixXd& center,
                     const MatrixXd& gradient,
                     const std::vector<MatrixXd>& roots,
                     const MatrixXd& all,
                     const VectorXd& tolerance,
                     bool split,
                     std::vector<NonlinearDirections>& result) {
  std::vector<Matrix> changes;
  changes.reserve(roots.size());
  for (const MatrixXd& root : roots) changes.emplace_back(root.cols(), all.cols());
  for (Index k = 0; k < all.cols(); ++k) {
    MatrixXd at = center;
    for (Index row = 0; row < at.rows(); ++row) {
      const MatrixXd& root = roots[static_cast<std::size_t>(row)];
      for (Index j = 0; j < root.cols(); ++j) at.row(row) += all(j, k) * root.col(j).transpose();
    }
    const MatrixXd change = mean.gradient(at) - gradient;
    for (Index row = 0; row < at.rows(); ++row) {
      const MatrixXd& root = roots[static_cast<std::size_t>(row)];
      Matrix& of_row = changes[static_cast<std::size_t>(row)];
      for (Index j = 0; j < root.cols(); ++j) of_row(j, k) = change.row(row).dot(root.col(j));
    }
  }
  for (std::size_t i = 0; i < roots.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const VectorXd slope = roots[i].transpose() * gradient.row(row).transpose();
    result.push_back(directions_of<Matrix>(roots[i], slope, changes[i], tolerance[row], split));
  }
}

}  // namespace

std::vector<bool> follow_one_combination(const RowMean& mean,
                                         const MatrixXd& center,
                                         const std::vector<MatrixXd>& roots,
                                         const VectorXd& tolerance) {
  std::vector<bool> result(roots.size(), true);
  Index width = 0;
  for (const MatrixXd& root : roots) width = std::max(width, root.cols());
  if (width < 2) return result;
  // One point shows a change, except of a mean with kinks.
  constexpr int kPoints = 4;
  Random random(1);
  VectorXd place(width);
  for (int point = 0; point < kPoints; ++point) {
    for (double& value : place) value = random.normal();
    MatrixXd along = center;
    MatrixXd aside = center;
    for (std::size_t i = 0; i < roots.size(); ++i) {
      const MatrixXd& root = roots[i];
      if (root.cols() < 2) continue;
      const auto row = static_cast<Index>(i);
      along.row(row) += place[0] * root.col(0).transpose();
      aside.row(row) += (root * place.head(root.cols())).transpose();
    }
    const VectorXd change = (mean.mean(aside) - mean.mean(along)).cwiseAbs();
    for (std::size_t i = 0; i < roots.size(); ++i) {
      const auto row = static_cast<Index>(i);
      if (roots[i].cols() > 1 && !(change[row] <= tolerance[row])) result[i] = false;
    }
  }
  return result;
}

Index probe_count(Index width) {
  if (width == 0) return 0;
  const auto main = static_cast<Index>(kMainProbes.size());
  return width == 1 ? main : main + 2 * (width - 1) + width + 2;
}

std::vector<NonlinearDirections> nonlinear_directions(const RowMean& mean,
                                                      const MatrixXd& center,
                                                      const MatrixXd& gradient,
                                                      const std::vector<MatrixXd>& roots,
                                                      const VectorXd& tolerance,
                                                      bool split) {
  Index width = 0;
  for (const MatrixXd& root : roots) width = std::max(width, root.cols());
  std::vector<NonlinearDirections> result;
  if (width == 0) {
    for (const MatrixXd& root : roots) result.push_back({.root = root});
    return result;
  }
  const MatrixXd all = probes(width);
  if (width <= kFewDirections && all.cols() <= FewRows::MaxColsAtCompileTime) {
    directions_from<FewRows>(mean, center, gradient, roots, all, tolerance, split, result);
  } else {
    directions_from<MatrixXd>(mean, center, gradient, roots, all, tolerance, split, result);
  }
  return result;
}

}  // namespace silvafit::fit
