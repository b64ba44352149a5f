// SPDX-License-Identifier: MIT
#include "mixed_effects/effect_columns.hpp"

#include <Eigen/QR>
#include <cmath>

namespace silvafit::fit {

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
  Index begin = 0;
  for (const int size : random.block_sizes()) {
    auto block = result.columns.middleCols(begin, size);
    const Eigen::HouseholderQR<MatrixXd> qr(block);
    const MatrixXd triangle = MatrixXd(qr.matrixQR().topRows(size).triangularView<Eigen::Upper>());
    result.triangle.block(begin, begin, size, size) = triangle / root;
    block = root * (qr.householderQ() * MatrixXd::Identity(block.rows(), size));
    begin += size;
  }
  result.covariance = result.triangle * psi * result.triangle.transpose();
  return result;
}

std::vector<MatrixXd> forms_of(const EffectColumns& level) {
  std::vector<MatrixXd> result;
  const Index q = level.triangle.rows();
  if (level.effects->has_equal_variances()) {
    result.emplace_back(level.triangle * level.triangle.transpose());
    // One effect has no correlation.
    if (q > 1 && level.effects->covariance == Covariance::kCompoundSymmetry) {
      const VectorXd sum = level.triangle.rowwise().sum();
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
