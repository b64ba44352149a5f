// SPDX-License-Identifier: MIT
// The marginal likelihood around its maximum.

#include "likelihood/integration_method.hpp"
#include "likelihood/likelihood_surface.hpp"
#include "likelihood/marginal_coordinates.hpp"
#include "likelihood/marginal_likelihood.hpp"
#include "result/estimated_terms.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

class MarginalSurface : public LikelihoodSurface {
 public:
  explicit MarginalSurface(const SurfaceSetting& setting)
      : LikelihoodSurface(
            {setting.model, setting.variance, setting.frame, setting.frame.beta.cols()}),
        likelihood_(setting.model,
                    setting.variance,
                    curvature_of(*integration_of(setting.fit.method)),
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
    if (gradient != nullptr) *gradient = coordinates_.gradient(value);
    return value.minus_log_likelihood;
  }

 private:
  MarginalLikelihood likelihood_;
  MarginalCoordinates coordinates_;
  VectorXd modes_;
};

}  // namespace

std::unique_ptr<LikelihoodSurface> make_marginal_surface(const SurfaceSetting& setting) {
  return std::make_unique<MarginalSurface>(setting);
}

}  // namespace silvafit::fit
