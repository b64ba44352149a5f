// SPDX-License-Identifier: MIT
#include "linear_mixed_profile.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Cross products of one group with Z taken out, and the small system A = I + L'Z'Z L.
struct GroupSystem {
  MatrixXd zz{};  ///< (q x q)
  MatrixXd zx{};  ///< (q x p)
  VectorXd zw{};  ///< (q)
  Eigen::LLT<MatrixXd> a{};

  template <typename Products>
  GroupSystem(const Products& products, const std::vector<Index>& random, const MatrixXd& factor) {
    const auto q = static_cast<Index>(random.size());
    const Index p = products.rows() - 1;
    zz.resize(q, q);
    zx.resize(q, p);
    zw.resize(q);
    for (Index i = 0; i < q; ++i) {
      for (Index j = 0; j < q; ++j) zz(i, j) = products(random[i], random[j]);
      zx.row(i) = products.row(random[i]).head(p);
      zw[i] = products(random[i], p);
    }
    a.compute(MatrixXd::Identity(q, q) + factor.transpose() * zz * factor);
  }

  double log_determinant() const { return 2.0 * a.matrixLLT().diagonal().array().log().sum(); }
};

}  // namespace

GroupMoments::GroupMoments(const LinearMixedModel& model, const Eigen::ArrayXd& weight)
    : groups_(static_cast<Index>(model.group_begin.size()) - 1), width_(model.design.cols() + 1) {
  products_.resize(width_, width_ * groups_);
  const Index p = model.design.cols();
  MatrixXd weighted;
  for (Index j = 0; j < groups_; ++j) {
    const Index begin = model.group_begin[j];
    const Index size = model.group_begin[j + 1] - begin;
    const auto x = model.design.middleRows(begin, size);
    const auto w = model.working.segment(begin, size);
    const auto g = weight.segment(begin, size);
    weighted = x.array().colwise() * g;
    auto target = products_.middleCols(j * width_, width_);
    target.topLeftCorner(p, p).noalias() = weighted.transpose() * x;
    target.col(p).head(p).noalias() = weighted.transpose() * w;
    target.row(p).head(p) = target.col(p).head(p).transpose();
    target(p, p) = (g * w.array().square()).sum();
  }
}

LinearMixedProfile profile(const LinearMixedModel& model,
                           const GroupMoments& moments,
                           double sum_log_scale,
                           const MatrixXd& factor) {
  const Index p = model.design.cols();
  const Index q = factor.rows();
  const auto n = static_cast<double>(model.working.size());
  LinearMixedProfile result;
  result.information.setZero(p, p);
  VectorXd right = VectorXd::Zero(p);
  double squares = 0.0;
  double log_determinants = 0.0;

  std::vector<GroupSystem> systems;
  systems.reserve(static_cast<std::size_t>(moments.groups()));
  for (Index j = 0; j < moments.groups(); ++j) {
    const auto products = moments.group(j);
    const GroupSystem& system = systems.emplace_back(products, model.random, factor);
    // Half of M = L A^-1 L' on each side: a difference of squares keeps the result symmetric.
    const MatrixXd half_x = system.a.matrixL().solve(factor.transpose() * system.zx);
    const VectorXd half_w = system.a.matrixL().solve(factor.transpose() * system.zw);
    result.information += products.topLeftCorner(p, p) - half_x.transpose() * half_x;
    right += products.col(p).head(p) - half_x.transpose() * half_w;
    squares += products(p, p) - half_w.squaredNorm();
    log_determinants += system.log_determinant();
  }
  const Eigen::LLT<MatrixXd> information(result.information);
  if (information.info() != Eigen::Success) return result;
  result.coefficients = information.solve(right);
  result.sum_of_squares = squares - result.coefficients.dot(right);
  if (!(result.sum_of_squares > 0.0)) return result;
  result.is_valid = true;
  const double sigma2 = result.sum_of_squares / n;
  result.minus_log_likelihood = 0.5 * n * (std::log(2.0 * std::numbers::pi * sigma2) + 1.0) +
                                0.5 * log_determinants + sum_log_scale;

  result.spherical.resize(q, moments.groups());
  result.by_factor.setZero(q, q);
  result.by_covariance.setZero(q, q);
  for (Index j = 0; j < moments.groups(); ++j) {
    const GroupSystem& system = systems[static_cast<std::size_t>(j)];
    const VectorXd ze = system.zw - system.zx * result.coefficients;
    const VectorXd v = system.a.solve(factor.transpose() * ze);
    result.spherical.col(j) = v;
    const VectorXd s = ze - system.zz * (factor * v);  // Z'V^-1 e
    // Z'V^-1 Z L = Z'Z L A^-1 without the cancellation of Z'V^-1 Z itself.
    const MatrixXd zzl = system.zz * factor;
    result.by_factor += system.a.solve(zzl.transpose()).transpose() - s * v.transpose() / sigma2;
    const MatrixXd half = system.a.matrixL().solve(zzl.transpose());
    result.by_covariance +=
        0.5 * (system.zz - half.transpose() * half - s * s.transpose() / sigma2);
  }
  return result;
}

VectorXd variance_gradient(const LinearMixedModel& model,
                           const GroupMoments& moments,
                           const ResidualScale& scale,
                           const MatrixXd& factor,
                           const LinearMixedProfile& at) {
  const auto q = static_cast<Index>(model.random.size());
  const double sigma2 = at.sum_of_squares / static_cast<double>(model.working.size());
  // By the envelope theorem only the weights move: dF/dd = sum l (1 - g^-2 (e^2/sigma^2 + z'Mz)).
  VectorXd residual = model.working - model.design * at.coefficients;
  Eigen::ArrayXd leverage = Eigen::ArrayXd::Zero(residual.size());
  for (Index j = 0; j < moments.groups() && q > 0; ++j) {
    const Index begin = model.group_begin[j];
    const Index size = model.group_begin[j + 1] - begin;
    const GroupSystem system(moments.group(j), model.random, factor);
    MatrixXd z(size, q);
    for (Index k = 0; k < q; ++k) z.col(k) = model.design.col(model.random[k]).segment(begin, size);
    residual.segment(begin, size) -= z * (factor * at.spherical.col(j));
    const MatrixXd half = system.a.matrixL().solve((z * factor).transpose());
    leverage.segment(begin, size) = half.colwise().squaredNorm().transpose().array();
  }
  const Eigen::ArrayXd factor_of_log =
      1.0 - scale.weight * (residual.array().square() / sigma2 + leverage);
  return scale.log_derivative.matrix().transpose() * factor_of_log.matrix();
}

}  // namespace silvafit::fit
