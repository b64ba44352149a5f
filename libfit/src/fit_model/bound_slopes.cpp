// SPDX-License-Identifier: MIT
#include "fit_model/bound_slopes.hpp"

#include <Eigen/LU>
#include <cmath>

#include "likelihood/likelihood_surface.hpp"

namespace silvafit::fit {
namespace {

/// The direction of length one in which one coefficient grows and no other changes.
VectorXd direction_of(const LikelihoodSurface& surface, Index coefficient) {
  const SurfaceLayout& layout = surface.layout();
  const Index p = layout.beta_count();
  VectorXd direction = VectorXd::Zero(layout.size());
  direction.head(p) = layout.frame().beta.partialPivLu().solve(VectorXd::Unit(p, coefficient));
  return direction.normalized();
}

/// The curvature of F along a direction, by differences of the exact gradient.
double curvature(LikelihoodSurface& surface,
                 const VectorXd& x,
                 const VectorXd& direction,
                 double step) {
  VectorXd gradient;
  const auto slope_at = [&](double shift) {
    const VectorXd moved = x + shift * direction;
    return std::isfinite(surface.value(moved, &gradient)) ? gradient.dot(direction) : NAN;
  };
  return (slope_at(step) - slope_at(-step)) / (2.0 * step);
}

}  // namespace

bool is_slope(double slope) {
  constexpr double kSmallest = 1e-4;
  return !(std::abs(slope) <= kSmallest);
}

HeldPoint at_held(const FittedModel& fit,
                  const data::Table& table,
                  const std::map<std::string, double>& fixed,
                  const std::map<std::string, double>& held) {
  HeldPoint result{.value = fit.log_likelihood};
  if (!(fit.sigma > 0.0)) {
    for (const auto& [name, value] : held) result.slopes[name] = 0.0;
    return result;
  }
  if (held.empty() && !fit.reml) return result;
  FittedModel unrestricted = fit;
  unrestricted.reml = false;
  const SurfaceSetting setting(unrestricted, table, fixed);
  const auto surface = make_surface(setting);
  const VectorXd& x = surface->optimum();
  VectorXd gradient;
  const double value = surface->value(x, &gradient);
  if (fit.reml) result.value = -value;
  // In these coordinates one unit changes the mean by a residual standard deviation, so that the
  // standard error of one coefficient is about one over the root of n.
  const auto n = static_cast<double>(fit.observations);
  const double step = 1e-3 / std::sqrt(n);
  for (const auto& [name, at] : held) {
    const Index j = setting.model.coefficient_index(name);
    const VectorXd direction = direction_of(*surface, j);
    const double found = curvature(*surface, x, direction, step);
    const double information = found > 0.0 && std::isfinite(found) ? found : n;
    result.slopes[name] =
        std::isfinite(value) ? -gradient.dot(direction) / std::sqrt(information) : NAN;
  }
  return result;
}

}  // namespace silvafit::fit
