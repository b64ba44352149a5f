// SPDX-License-Identifier: MIT
#include "prediction/prediction_freedom.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "model/covariance_factor.hpp"
#include "model/group_labels.hpp"
#include "model/symmetric_eigen.hpp"
#include "prediction/coefficient_sets.hpp"
#include "result/nested_effects.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Groups with a smaller reliability in a direction give no information about it.
constexpr double kLeastReliability = 1e-6;

/// Degrees of freedom of the residual variance: those of the t tests within the finest groups, but
/// at most the number of observations less that of groups. Held coefficients have none.
double residual_freedom(const FittedModel& fit) {
  double freedom = 1.0;
  for (const double value : fit.degrees_of_freedom) {
    if (std::isfinite(value)) freedom = std::max(freedom, value);
  }
  const auto within = fit.observations - static_cast<Index>(finer(fit).labels.size());
  if (fit.has_random_effects() && within > 0) {
    freedom = std::min(freedom, static_cast<double>(within));
  }
  return freedom;
}

/// Degrees of freedom between the units of a grouping: those of the layout, less one for each
/// coefficient that is estimated between them.
/// \param level  0: the coarsest grouping
double freedom_between(const FittedModel& fit, std::size_t level, double of_layout) {
  const std::vector<int>& coefficients = fit.coefficients_between;
  return std::max(1.0, of_layout - (level < coefficients.size() ? coefficients[level] : 0));
}

/// Inverse of a mean of reliabilities, whose eigenvalues lie between 0 and 1.
MatrixXd inverse_reliability(const MatrixXd& reliability) {
  const SymmetricEigen of = symmetric_eigen(reliability);
  const VectorXd inverse = of.values.cwiseMax(kLeastReliability).cwiseMin(1.0).cwiseInverse();
  return of.vectors * inverse.asDiagonal() * of.vectors.transpose();
}

/// The conditional covariance of the effects of the finer groups if those of the coarser ones are
/// known, as in the comparison of groups within coarser ones.
EffectUncertainty within_outer(const FittedModel& fit) {
  EffectUncertainty result = finer(fit).uncertainty;
  if (!result.is_known() || !coarser(fit).uncertainty.is_known()) return result;
  const LabelNumbers outer = numbered(outer_parts(coarser(fit).labels));
  const auto q = static_cast<Index>(finer(fit).names.size());
  const auto s = static_cast<Index>(coarser(fit).names.size());
  for (Index g = 0; g < result.covariances.cols(); ++g) {
    const std::string& label = finer(fit).labels[static_cast<std::size_t>(g)];
    const auto found = outer.find(std::string(nested_parts(label).outer));
    if (found == outer.end() || result.cross_covariances.cols() <= g) continue;
    const Index c = found->second;
    const MatrixXd cross = result.cross_covariance(g, q, s);
    const MatrixXd slopes = regression_on(cross, coarser(fit).uncertainty.covariance(c, s));
    result.covariances.col(g) -= (slopes * cross.transpose()).reshaped();
  }
  return result;
}

double share_of(double part, double whole) {
  return whole > 0.0 ? std::clamp(part, 0.0, whole) : 0.0;
}

}  // namespace

Freedom::Freedom(const FittedModel& fit) : residual_(residual_freedom(fit)) {
  if (!fit.has_random_effects()) return;
  const auto groups = static_cast<double>(finer(fit).labels.size());
  const auto clusters = static_cast<double>(coarser(fit).labels.size());
  const bool is_nested = !coarser(fit).names.empty();
  inner_ = grouping(fit,
                    finer(fit).names,
                    finer(fit).covariance,
                    is_nested ? within_outer(fit) : finer(fit).uncertainty,
                    is_nested ? freedom_between(fit, 1, groups - clusters)
                              : freedom_between(fit, 0, groups - 1.0));
  if (!is_nested) return;
  outer_ = grouping(fit,
                    coarser(fit).names,
                    coarser(fit).covariance,
                    coarser(fit).uncertainty,
                    freedom_between(fit, 0, clusters - 1.0));
}

// With Psi = R R', V = R (I - W) R' is what the trees of a group leave open of its effects, W their
// reliability and R W^-1 R' the covariance of the group's own estimates. The information on the
// coefficients is sum X'(Z Psi Z' + sigma^2 G)^-1 X, of which sum S' Psi^-1 S goes with Psi.
Freedom::Grouping Freedom::grouping(const FittedModel& fit,
                                    const std::vector<std::string>& names,
                                    const MatrixXd& covariance,
                                    const EffectUncertainty& uncertainty,
                                    double freedom) {
  Grouping result{.freedom = freedom, .effects = among_coefficients(fit, names, covariance)};
  const MatrixXd fixed = fixed_covariance(fit);
  const Index q = covariance.rows();
  const Index p = fit.estimate.size();
  result.spread = result.effects;
  result.in_fixed = fixed;
  if (!uncertainty.is_known() || !covariance.allFinite()) return result;
  const MatrixXd root = covariance_factor(covariance);
  const MatrixXd inverse = root.completeOrthogonalDecomposition().pseudoInverse();
  MatrixXd open = MatrixXd::Zero(q, q);
  MatrixXd information = MatrixXd::Zero(p, p);
  Index count = 0;
  for (Index g = 0; g < uncertainty.covariances.cols(); ++g) {
    const MatrixXd sensitivity = inverse * uncertainty.sensitivity(g, q, p);
    const MatrixXd left = inverse * uncertainty.covariance(g, q) * inverse.transpose();
    if (!sensitivity.allFinite() || !left.allFinite()) continue;
    open += left;
    information += sensitivity.transpose() * sensitivity;
    ++count;
  }
  if (count == 0) return result;
  const MatrixXd reliability = MatrixXd::Identity(q, q) - open / static_cast<double>(count);
  result.spread =
      among_coefficients(fit, names, root * inverse_reliability(reliability) * root.transpose());
  result.in_fixed = fixed * information * fixed;
  return result;
}

double Freedom::reliability(const Grouping& grouping, const Eigen::Ref<const VectorXd>& slope) {
  const double effects = slope.dot(grouping.effects * slope);
  const double spread = slope.dot(grouping.spread * slope);
  return effects > 0.0 && spread > effects ? effects / spread : 1.0;
}

VarianceParts Freedom::of_fixed(const Eigen::Ref<const VectorXd>& slope, double variance) const {
  VarianceParts parts{.total = variance};
  if (outer_.freedom > 0.0) parts.outer = share_of(slope.dot(outer_.in_fixed * slope), variance);
  if (inner_.freedom > 0.0) {
    parts.inner = share_of(slope.dot(inner_.in_fixed * slope), variance - parts.outer);
  }
  return parts;
}

double Freedom::value(const VarianceParts& parts, const Eigen::Ref<const VectorXd>& slope) const {
  double left = parts.total;
  double squares = 0.0;
  // The errors of the coarser groups' own curves, including the variance of the finer groups.
  double errors = 0.0;
  const auto take = [&](const Grouping& grouping, double part) {
    if (!(part > 0.0)) return;
    const double spread = share_of(part / reliability(grouping, slope) - errors, left);
    errors += spread - part;
    left -= spread;
    squares += spread * spread / grouping.freedom;
  };
  take(outer_, parts.outer);
  take(inner_, parts.inner);
  squares += left * left / residual_;
  return squares > 0.0 ? parts.total * parts.total / squares : residual_;
}

}  // namespace silvafit::fit
