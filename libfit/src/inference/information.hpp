// SPDX-License-Identifier: MIT
// The Hessian of a likelihood at its maximum, and the covariance of the reported parameters.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "inference/natural_parameters.hpp"
#include "inference/profile_search.hpp"
#include "likelihood/likelihood_surface.hpp"
#include "mixed_effects/confounded_variances.hpp"

namespace silvafit::fit {

/// Value, Hessian and its inverse at the maximum. The Hessian is that of central differences of the
/// exact gradient, and for ols exact.
ProfileStart start_of(const SurfaceSetting& setting, LikelihoodSurface& surface);

/// Whether the covariance of each term is singular (boundary fits): then none of its standard
/// deviations and correlations has a standard error.
struct BoundaryTerms {
  std::vector<bool> is_at_boundary{};
  bool contain(const NaturalParameter& parameter) const {
    const bool is_random = parameter.kind == ParameterKind::kDeviation ||
                           parameter.kind == ParameterKind::kCorrelation;
    return is_random && is_at_boundary[parameter.term];
  }
};
BoundaryTerms boundary_terms(const SurfaceLayout& layout, const Eigen::VectorXd& x);

/// Variance components that are not identifiable although the fit counts as converged, which is
/// possible in files of earlier versions.
ConfoundedVariances confounded_variances(const SurfaceSetting& setting);

/// (K x K) covariance of parameters on their symmetric scales, by the delta method; NaN where a
/// parameter is at the boundary of its range or not identifiable.
Eigen::MatrixXd symmetric_covariance(const SurfaceSetting& setting,
                                     LikelihoodSurface& surface,
                                     const std::vector<NaturalParameter>& parameters,
                                     const ProfileStart& start);

}  // namespace silvafit::fit
