// SPDX-License-Identifier: MIT
#include "prediction/prediction_freedom.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "model/small_matrix.hpp"
#include "model/symmetric_eigen.hpp"
#include "prediction/coefficient_sets.hpp"
#include "prediction/joint_posterior.hpp"

namespace silvafit::fit {
namespace {

// Groups with a smaller reliability in a direction give no information about it.
constexpr double kLeastReliability = 1e-6;

/// Degrees of freedom of the residual variance: those of the t tests within the finest groups, but
/// at most the number of observations less that of groups. Held coefficients have none.
double residual_freedom(const FittedModel& fit) {
  double freedom = 1.0;
  for (const double value : fit.degrees_of_freedom) {
    if (std::isfinite(value)) freedom = std::max(freedom, value);
  }
  if (!fit.has_random_effects()) return freedom;
  const bool has_estimates = fit.degrees_of_freedom.array().isFinite().any();
  if (!has_estimates && !fit.coefficients_between.empty())
    freedom = static_cast<double>(fit.observations);  // of a fit with random effects only
  Index within = fit.observations - std::ssize(fit.random.back().labels);
  if (are_crossed(fit.specification.random)) {
    within = fit.observations;
    for (const EstimatedEffects& term : fit.random) within -= std::ssize(term.labels);
  }
  return within > 0 ? std::min(freedom, static_cast<double>(within)) : freedom;
}

/// Degrees of freedom between the groups of a term: those of the layout, less one for each
/// coefficient that is estimated between them.
double freedom_between(const FittedModel& fit, std::size_t term) {
  const auto groups = [&](std::size_t t) {
    return static_cast<double>(fit.random[t].labels.size());
  };
  const bool is_alone = term == 0 || are_crossed(fit.specification.random);
  const double of_layout = groups(term) - (is_alone ? 1.0 : groups(term - 1));
  const std::vector<int>& coefficients = fit.coefficients_between;
  return std::max(1.0, of_layout - (term < coefficients.size() ? coefficients[term] : 0));
}

/// Inverse of a mean of reliabilities, whose eigenvalues lie between 0 and 1.
MatrixXd inverse_reliability(const MatrixXd& reliability) {
  const SymmetricEigen of = symmetric_eigen(reliability);
  const VectorXd inverse = of.values.cwiseMax(kLeastReliability).cwiseMin(1.0).cwiseInverse();
  return of.vectors * inverse.asDiagonal() * of.vectors.transpose();
}

/// The uncertainty of the effects of a term if those of the term before are known, as in the
/// comparison of groups within coarser ones.
EffectUncertainty within_coarser(const FittedModel& fit, std::size_t term) {
  EffectUncertainty result = fit.random[term].uncertainty;
  if (term == 0 || are_crossed(fit.specification.random)) return result;
  if (fit.cells.groups.empty()) return result;
  const RandomPlaces places = places_of(fit);
  const std::vector<Index>& rows = places.rows[term];
  const MatrixXd root = covariance_factor(fit.random[term].covariance);
  for (Index cell = 0; cell < fit.cells.curvatures.cols(); ++cell) {
    const MatrixXd curvature = unpacked(fit.cells.curvatures.col(cell).data(), places.r());
    const MatrixXd precision = MatrixXd::Identity(root.cols(), root.cols()) +
                               root.transpose() * curvature(rows, rows) * root;
    const Index group = fit.cells.groups[term][static_cast<std::size_t>(cell)];
    result.covariances.col(group) =
        (root * precision.llt().solve(MatrixXd(root.transpose()))).reshaped();
  }
  return result;
}

double share_of(double part, double whole) {
  return whole > 0.0 ? std::clamp(part, 0.0, whole) : 0.0;
}

}  // namespace

Freedom::Freedom(const FittedModel& fit) : residual_(residual_freedom(fit)) {
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    terms_.push_back(term(fit, fit.random[t], within_coarser(fit, t), freedom_between(fit, t)));
  }
}

// With Psi = R R', V = R (I - W) R' is what the trees of a group leave open of its effects, W their
// reliability and R W^-1 R' the covariance of the group's own estimates. The information on the
// coefficients is sum X'(Z Psi Z' + sigma^2 G)^-1 X, of which sum S' Psi^-1 S goes with Psi.
Freedom::Term Freedom::term(const FittedModel& fit,
                            const EstimatedEffects& effects,
                            const EffectUncertainty& uncertainty,
                            double freedom) {
  const std::vector<std::string>& names = effects.names;
  const MatrixXd& covariance = effects.covariance;
  Term result{.freedom = freedom, .effects = among_coefficients(fit, names, covariance)};
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

double Freedom::reliability(const Term& term, const Eigen::Ref<const VectorXd>& slope) {
  const double effects = slope.dot(term.effects * slope);
  const double spread = slope.dot(term.spread * slope);
  return effects > 0.0 && spread > effects ? effects / spread : 1.0;
}

VarianceParts Freedom::of_fixed(const Eigen::Ref<const VectorXd>& slope, double variance) const {
  VarianceParts parts{.total = variance, .of_terms = SmallVector::Zero(std::ssize(terms_))};
  double left = variance;
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    double& part = parts.of_terms[static_cast<Index>(t)];
    part = share_of(slope.dot(terms_[t].in_fixed * slope), left);
    left -= part;
  }
  return parts;
}

double Freedom::value(const VarianceParts& parts, const Eigen::Ref<const VectorXd>& slope) const {
  double left = parts.total;
  double squares = 0.0;
  // The errors of the own curves of the groups so far, including the variance of finer groups.
  double errors = 0.0;
  for (Index t = 0; t < parts.of_terms.size(); ++t) {
    const Term& term = terms_[static_cast<std::size_t>(t)];
    const double part = parts.of_terms[t];
    if (!(part > 0.0)) continue;
    const double spread = share_of(part / reliability(term, slope) - errors, left);
    errors += spread - part;
    left -= spread;
    squares += spread * spread / term.freedom;
  }
  squares += left * left / residual_;
  return squares > 0.0 ? parts.total * parts.total / squares : residual_;
}

}  // namespace silvafit::fit
