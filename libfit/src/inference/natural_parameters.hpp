// SPDX-License-Identifier: MIT
// The reported parameters as functions of the parameter vector of a likelihood, and that vector
// with one of them held.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "likelihood/likelihood_surface.hpp"
#include "silvafit/fit/derived_quantity.hpp"
#include "silvafit/fit/parameter_intervals.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {

/// One reported parameter: a coefficient, a standard deviation or correlation of random effects, a
/// parameter of the variance function, or sigma.
class NaturalParameter {
 public:
  enum class Form {
    kCoefficient,  ///< a combination of the first coordinates
    kDerived,      ///< a function of the coefficients
    kCoordinate,   ///< factor times a coordinate
    kExponential,  ///< exp of a coordinate
    kSquare,       ///< square of a coordinate
    kOdds,         ///< the constant of constant-plus-power: tan^2 of a coordinate times P(delta)
    kDeviation,    ///< length of a row of a factor
    kIdentity,     ///< |factor times a coordinate|: a standard deviation of the identity form
    kCommonDeviation,    ///< of compound symmetry, a function of two coordinates
    kCommonCorrelation,  ///< the same
    kCorrelation,        ///< cosine between two rows of a factor
    kResidual,           ///< of the correlation of residuals
    kSigma,              ///< exp of a coordinate times a function of the variance parameters
  };

  ParameterKind kind = ParameterKind::kFixed;
  std::string name{};
  Form form = Form::kCoordinate;
  std::size_t term = 0;        ///< of kDeviation, kIdentity and kCorrelation
  Eigen::Index row = 0;        ///< of the factor
  Eigen::Index other_row = 0;  ///< of kCorrelation; row < other_row
  Eigen::Index coordinate = 0;
  Eigen::Index delta = 0;  ///< of kOdds: the coordinate of delta
  double scale = 1.0;      ///< factor of kCoordinate and of equal deviations, unit of kDeviation
  TypicalValue typical{};  ///< of kOdds
  /// (p) of kCoefficient, and the slopes of kDerived at the estimate; `coordinate` has the largest.
  Eigen::VectorXd weights{};
  /// Of kDerived, with its own names of the coefficients.
  std::optional<DerivedQuantity> derived{};
  std::vector<std::string> coefficients{};
  double low = 0.0;  ///< range of kResidual and kCommonCorrelation
  double high = 1.0;

  /// Whether hold() is possible: a correlation of residuals may depend on several coordinates.
  bool can_be_held(const VarianceModel& variance) const;
  /// The value at x.
  double value(const SurfaceLayout& layout,
               const VarianceModel& variance,
               const Eigen::VectorXd& x) const;
  /// Moves a point near one at which a derived quantity has a value, and chooses the coordinate of
  /// its steepest slope there for hold(): in that of the estimate the quantity may not reach the
  /// value, as a product of two coefficients along a ridge. Other parameters need neither.
  void hold_near(const SurfaceLayout& layout, double value, Eigen::VectorXd& free);
  /// x with this parameter held at a value, and the other elements near those given.
  Eigen::VectorXd hold(const SurfaceLayout& layout,
                       const VarianceModel& variance,
                       const Eigen::VectorXd& free,
                       double value) const;
  /// The gradient by `free` of a function of hold(free), from its gradient there.
  Eigen::VectorXd pull_back(const SurfaceLayout& layout,
                            const VarianceModel& variance,
                            const Eigen::VectorXd& free,
                            double value,
                            const Eigen::VectorXd& gradient) const;

 private:
  void hold_derived(const SurfaceLayout& layout, double value, Eigen::VectorXd& x) const;
  Eigen::VectorXd derived_slopes(const SurfaceLayout& layout, const Eigen::VectorXd& x) const;
};

/// All parameters of a fit in the order of the report. Names are those of the result: "a", "b:C",
/// "sd(a)", "cor(a, b)", "sd(a
/// stand)" with two groupings, "delta", "constant", "ratio (BHN)", "sigma".
std::vector<NaturalParameter> natural_parameters(const SurfaceSetting& setting,
                                                 const SurfaceLayout& layout);

/// The derived quantities of a fit, of a likelihood that has fixed effects.
std::vector<NaturalParameter> derived_parameters(const SurfaceSetting& setting,
                                                 const SurfaceLayout& layout);

/// The scale on which an interval of Wald is symmetric: log of standard deviations, constants and
/// ratios, log((1 + r) / (1 - r)) of correlations, and the same for the range of parameters of the
/// residuals' correlation, as R nlme; coefficients and delta as they are.
double to_symmetric(const NaturalParameter& parameter, double value);
double from_symmetric(const NaturalParameter& parameter, double value);

}  // namespace silvafit::fit
