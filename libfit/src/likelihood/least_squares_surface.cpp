// SPDX-License-Identifier: MIT
// The likelihood of a nonlinear mean with independent normal residuals.
#include <cmath>
#include <numbers>

#include "likelihood/likelihood_surface.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

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

}  // namespace

std::unique_ptr<LikelihoodSurface> make_least_squares_surface(const SurfaceSetting& setting) {
  return std::make_unique<LeastSquaresSurface>(setting);
}

}  // namespace silvafit::fit
