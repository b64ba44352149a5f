// SPDX-License-Identifier: MIT
#include "mixed_effects/effect_columns.hpp"

#include <cmath>
#include <vector>

#include "verdict/thresholds.hpp"

namespace silvafit::fit {

namespace {

/// Makes the columns of a block orthogonal, one after the other. One that depends on those before
/// becomes 0, and its combination with them is a redundant one.
void orthogonalize(Index begin, Index count, EffectColumns& level) {
  auto block = level.columns.middleCols(begin, count);
  const double root = std::sqrt(static_cast<double>(block.rows()));
  std::vector<Index> independent;
  for (Index k = 0; k < count; ++k) {
    const auto rank = static_cast<Index>(independent.size());
    VectorXd column = block.col(k);
    VectorXd shares = VectorXd::Zero(rank);
    // Twice is enough for orthogonality to rounding errors (Giraud and others 2005).
    for (int pass = 0; pass < 2; ++pass) {
      for (Index i = 0; i < rank; ++i) {
        const VectorXd& of = block.col(independent[static_cast<std::size_t>(i)]);
        const double share = of.dot(column) / (root * root);
        shares[i] += share;
        column -= share * of;
      }
    }
    for (Index i = 0; i < rank; ++i) {
      level.triangle(begin + independent[static_cast<std::size_t>(i)], begin + k) = shares[i];
    }
    const double rest = column.norm() / root;
    if (rest > Thresholds::kUnfelt * level.size[begin + k]) {
      level.triangle(begin + k, begin + k) = rest;
      block.col(k) = column / rest;
      independent.push_back(k);
      continue;
    }
    block.col(k).setZero();
    level.triangle(begin + k, begin + k) = level.size[begin + k];
    VectorXd combination = VectorXd::Unit(level.columns.cols(), begin + k);
    const Eigen::VectorX<Index> places =
        Eigen::Map<const Eigen::VectorX<Index>>(independent.data(), rank).array() + begin;
    const MatrixXd triangle = level.triangle(places, places);
    combination(places) = -triangle.triangularView<Eigen::Upper>().solve(shares);
    level.redundant.conservativeResize(level.columns.cols(), level.redundant.cols() + 1);
    level.redundant.rightCols(1) = combination.cwiseProduct(level.size);
  }
  const auto rank = static_cast<Index>(independent.size());
  level.free_covariances += (count * (count + 1) - rank * (rank + 1)) / 2;
}

}  // namespace

EffectColumns effect_columns(const NonlinearModel& model,
                             const RandomEffects& random,
                             const MatrixXd& psi,
                             const MatrixXd& jacobian) {
  EffectColumns result{.effects = &random};
  result.columns = jacobian(Eigen::all, model.coefficients_of(random));
  const Index q = result.columns.cols();
  const double root = std::sqrt(static_cast<double>(jacobian.rows()));
  result.size = result.columns.colwise().norm() / root;
  result.triangle = MatrixXd::Zero(q, q);
  result.redundant.resize(q, 0);
  Index begin = 0;
  for (const int size : random.block_sizes()) {
    orthogonalize(begin, size, result);
    begin += size;
  }
  result.covariance = result.triangle * psi * result.triangle.transpose();
  return result;
}

std::vector<MatrixXd> forms_of(const EffectColumns& level) {
  std::vector<MatrixXd> result;
  const Index q = level.triangle.rows();
  if (level.effects->has_equal_variances()) {
    // In units of the columns, and with the largest element 1 as all others.
    const double largest = level.triangle.cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) return {MatrixXd::Zero(q, q)};
    const MatrixXd triangle = level.triangle / largest;
    result.emplace_back(triangle * triangle.transpose());
    // One effect has no correlation.
    if (q > 1 && level.effects->covariance == Covariance::kCompoundSymmetry) {
      const VectorXd sum = triangle.rowwise().sum();
      result.emplace_back(sum * sum.transpose());
    }
    return result;
  }
  Index begin = 0;
  for (const int size : level.effects->block_sizes()) {
    for (Index i = begin; i < begin + size; ++i) {
      for (Index j = begin; j <= i; ++j) {
        MatrixXd& form = result.emplace_back(MatrixXd::Zero(q, q));
        form(i, j) = form(j, i) = 1.0;
      }
    }
    begin += size;
  }
  return result;
}

}  // namespace silvafit::fit
