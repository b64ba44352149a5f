// SPDX-License-Identifier: MIT
// The likelihood of the linearization of the mixed model at the estimates.
#include <cmath>

#include "likelihood/likelihood_surface.hpp"
#include "likelihood/linear_mixed_profile.hpp"
#include "likelihood/linearization.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

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
      const VectorXd slopes = layout_.factor(t).gradient(at.by_factor[t]) / sigma;
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

}  // namespace

std::unique_ptr<LikelihoodSurface> make_linearized_surface(const SurfaceSetting& setting) {
  return std::make_unique<LinearizedSurface>(setting);
}

}  // namespace silvafit::fit
