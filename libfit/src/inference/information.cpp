// SPDX-License-Identifier: MIT
#include "inference/information.hpp"

#include <algorithm>
#include <cmath>

#include "least_squares/least_squares_curvature.hpp"
#include "model/symmetric_eigen.hpp"
#include "optimization/curvature_certificate.hpp"
#include "optimization/quasi_newton.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Whether a scaled factor has a row of length near 0, or rows that are linearly dependent. A
/// variance that all rows share is 0 if all of them are near 0.
bool is_at_boundary(const SurfaceLayout& layout, const VectorXd& x, std::size_t term) {
  MatrixXd factor = layout.factor(term).factor(layout.factor_part(x, term));
  constexpr double kNoEffect = 1e-4;
  constexpr double kDependent = 1e-6;
  const VectorXd lengths = factor.rowwise().norm();
  const bool is_shared = layout.factor(term).has_equal_variances();
  if ((is_shared ? lengths.maxCoeff() : lengths.minCoeff()) < kNoEffect) return true;
  factor = lengths.cwiseInverse().asDiagonal() * factor;
  return symmetric_eigen(factor * factor.transpose()).values[0] < kDependent;
}

double symmetric_value(const SurfaceSetting& setting,
                       const LikelihoodSurface& surface,
                       const NaturalParameter& parameter,
                       const VectorXd& x) {
  return to_symmetric(parameter, parameter.value(surface.layout(), setting.variance, x));
}

VectorXd symmetric_slopes(const SurfaceSetting& setting,
                          const LikelihoodSurface& surface,
                          const NaturalParameter& parameter) {
  const VectorXd& x = surface.optimum();
  VectorXd slopes(x.size());
  // The function is smooth and of order one; central differences keep ten digits.
  constexpr double kStep = 1e-5;
  for (Index k = 0; k < x.size(); ++k) {
    VectorXd above = x;
    VectorXd below = x;
    const double step = kStep * std::max(std::abs(x[k]), 0.1);
    above[k] += step;
    below[k] -= step;
    slopes[k] = (symmetric_value(setting, surface, parameter, above) -
                 symmetric_value(setting, surface, parameter, below)) /
                (above[k] - below[k]);
  }
  return slopes;
}

/// The first label of the strata whose standard deviations have ratios; empty if there are none.
std::string reference_stratum(const FittedModel& fit) {
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    if (factor.ratio.size() > 0 && !factor.strata.empty()) return factor.strata.front();
  }
  return {};
}

/// The stratum of a parameter of the variance function, "" if it has none.
std::string stratum_of(const NaturalParameter& parameter) {
  const std::string& name = parameter.name;
  const bool is_of_stratum = parameter.kind == ParameterKind::kVariance && name.ends_with(')');
  const std::size_t open = is_of_stratum ? name.rfind(" (") : std::string::npos;
  return open == std::string::npos ? "" : name.substr(open + 2, name.size() - open - 3);
}

/// Whether a parameter belongs to a stratum without residuals: its own, and the likelihood does not
/// depend on it. Sigma is the standard deviation of the reference.
bool is_of_exact_stratum(const FittedModel& fit, const NaturalParameter& parameter) {
  const std::string stratum =
      parameter.kind == ParameterKind::kSigma ? reference_stratum(fit) : stratum_of(parameter);
  return fit.convergence.has(Evidence::Kind::kBoundary, "sd of " + stratum);
}

/// Whether a parameter of the residuals' variance or correlation is at an end of its range. Without
/// a range the nugget has no effect.
bool is_at_end(const FittedModel& fit, const NaturalParameter& parameter) {
  const auto is_end = [&](const std::string& name) {
    return fit.convergence.has(Evidence::Kind::kBoundary, name);
  };
  const std::string& name = parameter.name;
  const std::string stratum = stratum_of(parameter);
  const std::string of = stratum.empty() ? "" : " of " + stratum;
  if (name.starts_with("constant") && is_end("the constant of the variance function" + of)) {
    return true;
  }
  if (name.starts_with("ratio") && is_end("sd of " + reference_stratum(fit))) return true;
  return is_of_exact_stratum(fit, parameter) || is_end(name) ||
         (name == "nugget" && is_end("range"));
}

/// The inverse of the Hessian with some coordinates held: what rounding errors make of their
/// curvature, which is 0, would be taken for information. NaN if these errors, which another
/// difference shows, are larger than the curvature in other directions, too: nearly exact rows
/// have weights that leave no digits of the others.
MatrixXd inverse_without(const std::vector<Index>& held,
                         const MatrixXd& hessian,
                         LikelihoodSurface& surface) {
  std::vector<Index> free;
  for (Index k = 0; k < hessian.rows(); ++k) {
    if (std::ranges::find(held, k) == held.end()) free.push_back(k);
  }
  const VectorXd& x = surface.optimum();
  const SmoothFunction function = [&](const VectorXd& at, VectorXd* slope) {
    return surface.value(at, slope);
  };
  VectorXd gradient(x.size());
  surface.value(x, &gradient);
  const MatrixXd own = hessian(free, free);
  const MatrixXd errors = one_sided_hessian(function, x, gradient)(free, free) - own;
  const VectorXd unit = own.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const VectorXd curvatures = symmetric_eigen(unit.asDiagonal() * own * unit.asDiagonal()).values;
  const bool is_known =
      (unit.asDiagonal() * errors * unit.asDiagonal()).norm() < curvatures[curvatures.size() / 2];
  MatrixXd result = MatrixXd::Constant(hessian.rows(), hessian.cols(), is_known ? 0.0 : kNaN);
  if (is_known) result(free, free) = informed_inverse(own);
  return result;
}

}  // namespace

ProfileStart start_of(const SurfaceSetting& setting, LikelihoodSurface& surface) {
  const VectorXd& x = surface.optimum();
  const SmoothFunction function = [&](const VectorXd& at, VectorXd* gradient) {
    return surface.value(at, gradient);
  };
  const bool is_jagged =
      setting.fit.method == Method::kQuadrature && !setting.model.random_kinks().empty();
  VectorXd gradient(x.size());
  ProfileStart start{.value = surface.value(x, &gradient)};
  start.hessian = is_jagged ? hessian_over_errors(function, x, gradient)
                            : hessian_from_gradients(function, x, gradient);
  if (setting.fit.method == Method::kOrdinary) {
    const SurfaceLayout& layout = surface.layout();
    const Index p = layout.beta_count();
    const double precision = std::exp(-2.0 * x[layout.sigma_at()]);
    start.hessian.topLeftCorner(p, p) = precision * layout.frame().beta.transpose() *
                                        least_squares_hessian(setting.model, setting.estimate) *
                                        layout.frame().beta;
  }
  start.inverse = informed_inverse(start.hessian);
  return start;
}

BoundaryTerms boundary_terms(const SurfaceLayout& layout, const VectorXd& x) {
  BoundaryTerms result;
  for (std::size_t term = 0; term < layout.terms(); ++term) {
    result.is_at_boundary.push_back(is_at_boundary(layout, x, term));
  }
  return result;
}

ConfoundedVariances confounded_variances(const SurfaceSetting& setting) {
  if (setting.fit.method == Method::kOrdinary) return {};
  VariancePoint point{.effects = covariances_of(setting.fit),
                      .variance = setting.internal,
                      .is_restricted = setting.fit.reml};
  point.coefficients = coefficient_effects(setting.fit, setting.model).colwise() +
                       setting.model.extended(setting.estimate);
  point.fitted = setting.model.mean_at(point.coefficients);
  const ResidualScale scale = setting.variance.scale(point.fitted, setting.internal, false);
  point.residual_sd = std::exp(setting.log_sigma) * scale.weight.rsqrt();
  return confounded_variances(setting.model, setting.variance, point);
}

MatrixXd symmetric_covariance(const SurfaceSetting& setting,
                              LikelihoodSurface& surface,
                              const std::vector<NaturalParameter>& parameters,
                              const ProfileStart& start) {
  const BoundaryTerms boundary = boundary_terms(surface.layout(), surface.optimum());
  const std::vector<std::string> confounded = confounded_variances(setting).names;
  MatrixXd jacobian(static_cast<Index>(parameters.size()), surface.optimum().size());
  std::vector<Index> held;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const NaturalParameter& parameter = parameters[k];
    VectorXd slopes = symmetric_slopes(setting, surface, parameter);
    const bool is_confounded = std::ranges::find(confounded, parameter.name) != confounded.end();
    if (boundary.contain(parameter) || is_confounded || is_at_end(setting.fit, parameter) ||
        !slopes.allFinite())
      slopes.setConstant(kNaN);
    jacobian.row(static_cast<Index>(k)) = slopes;
    if (!is_of_exact_stratum(setting.fit, parameter)) continue;
    const bool is_sigma = parameter.kind == ParameterKind::kSigma;
    held.push_back(is_sigma ? surface.layout().sigma_at() : parameter.coordinate);
  }
  const MatrixXd inverse =
      held.empty() ? start.inverse : inverse_without(held, start.hessian, surface);
  return jacobian * inverse * jacobian.transpose();
}

}  // namespace silvafit::fit
