// SPDX-License-Identifier: MIT
#include "likelihood/likelihood_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "likelihood/linear_mixed_profile.hpp"
#include "likelihood/linearization.hpp"
#include "likelihood/marginal_coordinates.hpp"
#include "likelihood/marginal_likelihood.hpp"
#include "model/held_coefficients.hpp"
#include "model/response_fingerprint.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

/// Coefficients of a converged fit that have no standard error are held at a value or a bound.
std::map<std::string, double> held_by(const FittedModel& fit) {
  if (!fit.convergence.converged()) {
    throw UsageError("intervals need a converged fit: " + fit.convergence.verdict());
  }
  if (!(fit.sigma > 0.0)) {
    throw UsageError("perfect fit: the residuals are zero, so there are no intervals");
  }
  std::map<std::string, double> held;
  for (Index j = 0; j < fit.estimate.size(); ++j) {
    if (!std::isnan(fit.covariance(j, j))) continue;
    held[fit.coefficient_names[static_cast<std::size_t>(j)]] = fit.estimate[j];
  }
  return held;
}

VectorXd free_estimate(const FittedModel& fit, const std::map<std::string, double>& held) {
  VectorXd result(fit.estimate.size());
  Index count = 0;
  for (Index j = 0; j < result.size(); ++j) {
    const std::string& name = fit.coefficient_names[static_cast<std::size_t>(j)];
    if (!held.contains(name)) result[count++] = fit.estimate[j];
  }
  return result.head(count);
}

void check_same_data(const FittedModel& fit, const NonlinearModel& model) {
  const bool is_same = fit.observations == model.observations() &&
                       (fit.response_fingerprint.empty() ||
                        fit.response_fingerprint == response_fingerprint(model.response()));
  if (is_same) return;
  throw UsageError(
      fmt::format("the table is not the data of the fit: the fit has {} rows, the table has {} "
                  "usable rows or other responses; select the same rows",
                  fit.observations,
                  model.observations()));
}

CoefficientFrame frame_of(const FittedModel& fit,
                          const NonlinearModel& model,
                          const VectorXd& estimate) {
  return is_linearized(fit) ? shared_frame_at(model, estimate) : frame_at(model, estimate);
}

/// The likelihood of a nonlinear mean with independent normal residuals.
class LeastSquaresSurface : public LikelihoodSurface {
 public:
  explicit LeastSquaresSurface(const SurfaceSetting& setting)
      : LikelihoodSurface(
            {setting.model, setting.variance, setting.frame, setting.estimate.size()}),
        model_(setting.model),
        variance_(setting.variance) {
    model_.evaluate(setting.estimate, fitted_, nullptr, workspace_);
    double log_sigma = setting.log_sigma;
    if (setting.fit.method == Method::kOrdinary) {
      // Its sigma has n - p in the denominator; that of maximum likelihood has n.
      const double squares = (model_.response() - fitted_).squaredNorm();
      log_sigma = 0.5 * std::log(squares / static_cast<double>(model_.observations()));
    }
    optimum_ = setting.coordinates(layout_, log_sigma);
  }

  double value(const VectorXd& x, VectorXd* gradient) override {
    constexpr double kOutside = kInfinity;
    if (!x.allFinite()) return kOutside;
    const auto n = static_cast<double>(model_.observations());
    model_.evaluate(layout_.beta(x), mean_, gradient != nullptr ? &jacobian_ : nullptr, workspace_);
    const ResidualScale scale =
        variance_.scale(fitted_, layout_.variance_part(x), gradient != nullptr);
    const double log_sigma = x[layout_.sigma_at()];
    const double precision = std::exp(-2.0 * log_sigma);
    const VectorXd residual = model_.response() - mean_;
    const VectorXd weighted = precision * scale.weight.matrix().cwiseProduct(residual);
    const double squares = weighted.dot(residual);
    const double value =
        0.5 * n * std::log(2.0 * std::numbers::pi) + n * log_sigma + scale.sum_log + 0.5 * squares;
    if (!std::isfinite(value)) return kOutside;
    if (gradient == nullptr) return value;
    gradient->setZero(layout_.size());
    gradient->head(layout_.beta_count()) = -layout_.beta_gradient(jacobian_.transpose() * weighted);
    if (layout_.variance_count() > 0) {
      const VectorXd surprise = (1.0 - weighted.array() * residual.array()).matrix();
      gradient->segment(layout_.variance_at(), layout_.variance_count()) =
          scale.log_derivative.matrix().transpose() * surprise;
    }
    (*gradient)[layout_.sigma_at()] = n - squares;
    if (!gradient->allFinite()) return kOutside;
    return value;
  }

 private:
  const NonlinearModel& model_;
  const VarianceModel& variance_;
  NonlinearModel::Workspace workspace_;
  VectorXd fitted_;  ///< (N) at the estimates, for the weights
  VectorXd mean_;
  MatrixXd jacobian_;
};

/// The likelihood of the linearization of the mixed model at the estimates.
class LinearizedSurface : public LikelihoodSurface {
 public:
  explicit LinearizedSurface(const SurfaceSetting& setting)
      : LikelihoodSurface({setting.model,
                           setting.variance,
                           setting.frame,
                           setting.fit.reml ? 0 : setting.estimate.size()}),
        model_(setting.model),
        is_restricted_(setting.fit.reml),
        linearizer_(setting.model, setting.variance),
        point_{.coefficients = setting.model.extended(setting.estimate),
               .effects = coefficient_effects(setting.fit, setting.model),
               .variance = setting.internal,
               .units = setting.frame.units(),
               .mixing = setting.frame.mixing()} {
    optimum_ = setting.coordinates(layout_, setting.log_sigma);
    is_valid_ = linearize(setting.internal);
  }

  double value(const VectorXd& x, VectorXd* gradient) override {
    constexpr double kOutside = kInfinity;
    model_.check_stop();
    if (!x.allFinite()) return kOutside;
    const VectorXd variance = layout_.variance_part(x);
    if (variance != point_.variance || !is_valid_) is_valid_ = linearize(variance);
    if (!is_valid_) return kOutside;
    const double sigma = std::exp(x[layout_.sigma_at()]);
    RelativeFactors factors;
    for (std::size_t t = 0; t < layout_.terms(); ++t) {
      factors.emplace_back(layout_.factor(t).factor(layout_.factor_part(x, t)) / sigma);
    }
    HeldParameters held{.sigma2 = sigma * sigma};
    if (!is_restricted_) {
      held.coefficients = x.head(layout_.beta_count()) - optimum_.head(layout_.beta_count());
    }
    const LinearMixedProfile at =
        profile(at_.model, factors, VectorXd::Zero(variance.size()), gradient != nullptr, held);
    if (!at.is_valid) return kOutside;
    if (gradient == nullptr) return at.minus_log_likelihood;
    gradient->setZero(layout_.size());
    if (!is_restricted_) gradient->head(layout_.beta_count()) = at.by_coefficients;
    // L is the factor relative to sigma, so that sigma moves it too.
    double by_log_sigma = at.by_log_sigma;
    for (std::size_t t = 0; t < layout_.terms(); ++t) {
      const VectorXd slopes =
          layout_.factor(t).gradient(layout_.factor_part(x, t), at.by_factor[t]) / sigma;
      gradient->segment(layout_.factor_at(t), slopes.size()) = slopes;
      by_log_sigma -= slopes.dot(layout_.factor_part(x, t));
    }
    if (variance.size() > 0) {
      gradient->segment(layout_.variance_at(), variance.size()) = at.by_variance;
    }
    (*gradient)[layout_.sigma_at()] = by_log_sigma;
    return at.minus_log_likelihood;
  }

 private:
  /// Computes the weights at other variance parameters, with the mean and Jacobian of the
  /// estimates.
  bool linearize(const VectorXd& variance) {
    point_.variance = variance;
    at_.model.restricted = is_restricted_;
    at_.model.log_units = -2.0 * layout_.frame().beta.diagonal().array().log().sum();
    return linearizer_.linearize(point_, variance.size() > 0, nullptr, at_);
  }

  const NonlinearModel& model_;
  bool is_restricted_;
  Linearizer linearizer_;
  LinearizationPoint point_;
  Linearization at_;
  bool is_valid_ = false;
};

/// The marginal likelihood around its maximum.
class MarginalSurface : public LikelihoodSurface {
 public:
  explicit MarginalSurface(const SurfaceSetting& setting)
      : LikelihoodSurface(
            {setting.model, setting.variance, setting.frame, setting.frame.beta.cols()}),
        likelihood_(setting.model,
                    setting.variance,
                    curvature_of(setting.fit.method),
                    setting.fit.method == Method::kQuadrature ? setting.fit.quadrature_points : 1),
        coordinates_(setting.model, setting.variance, setting.frame) {
    optimum_ = setting.coordinates(layout_, setting.log_sigma);
    const MarginalPoint point = coordinates_.point(optimum_);
    likelihood_.set_modes(
        likelihood_.layout().from_terms(coordinates_.spherical(optimum_, effects_of(setting.fit))));
    likelihood_.evaluate(point, false);
    modes_ = likelihood_.modes();
  }

  double value(const VectorXd& x, VectorXd* gradient) override {
    if (!x.allFinite()) return kInfinity;
    const MarginalPoint point = coordinates_.point(x);
    // Always from the modes of the estimates, so that a value depends only on x: if a group has
    // several modes, the last search may have ended in another one.
    likelihood_.set_modes(modes_);
    const MarginalValue value = likelihood_.evaluate(point, gradient != nullptr);
    if (gradient != nullptr) *gradient = coordinates_.gradient(x, value);
    return value.minus_log_likelihood;
  }

 private:
  MarginalLikelihood likelihood_;
  MarginalCoordinates coordinates_;
  VectorXd modes_;
};

}  // namespace

SurfaceSetting::SurfaceSetting(const FittedModel& of,
                               const data::Table& table,
                               std::stop_token stop)
    : SurfaceSetting(of, table, held_by(of), std::move(stop)) {}

SurfaceSetting::SurfaceSetting(const FittedModel& of,
                               const data::Table& table,
                               const std::map<std::string, double>& held,
                               std::stop_token stop)
    : fit(of),
      model(held.empty() ? of.specification : with_held(of.specification, held),
            table,
            1,
            std::move(stop)),
      variance(model.specification().variance, VarianceData::of(model)),
      estimate(free_estimate(of, held)),
      frame(frame_of(of, model, estimate)),
      internal(variance.parameters(of.variance)),
      log_sigma(std::log(of.sigma / variance.sigma_factor(internal))) {
  check_same_data(fit, model);
}

VectorXd SurfaceSetting::coordinates(const SurfaceLayout& layout, double at_log_sigma) const {
  return layout.coordinates(estimate, covariances_of(fit), internal, at_log_sigma);
}

std::unique_ptr<LikelihoodSurface> make_surface(const SurfaceSetting& setting) {
  if (is_marginal(setting.fit.method)) return std::make_unique<MarginalSurface>(setting);
  if (is_linearized(setting.fit)) return std::make_unique<LinearizedSurface>(setting);
  return std::make_unique<LeastSquaresSurface>(setting);
}

bool is_linearized(const FittedModel& fit) {
  return fit.method == Method::kLindstromBates || fit.reml || fit.specification.correlation;
}

std::string likelihood_in_words(const FittedModel& fit) {
  if (is_marginal(fit.method)) {
    return fmt::format("marginal likelihood by {}", word_of(fit.method));
  }
  if (is_linearized(fit)) {
    return fmt::format("{}likelihood of the model linear around the estimates",
                       fit.reml ? "restricted " : "");
  }
  if (fit.method == Method::kOrdinary) return "sum of squares of the nonlinear model";
  return "likelihood of the nonlinear model, with weights from the fitted values of the estimates";
}

}  // namespace silvafit::fit
