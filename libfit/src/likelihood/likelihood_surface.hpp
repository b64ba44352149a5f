// SPDX-License-Identifier: MIT
// The likelihood that a fit maximized, as a function of all of its parameters around the estimates.
#pragma once

#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "likelihood/surface_layout.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Common data of the surfaces of one fit: the model with the data, without held coefficients.
struct SurfaceSetting {
  /// \throws UsageError if the fit did not converge, or the table is not the one it was made of
  SurfaceSetting(const FittedModel& fit, const data::Table& table, std::stop_token stop = {});
  /// \param held  coefficients that the surface does not have, and their values; it has all others,
  ///   also those that the fit held
  /// \throws UsageError if the table is not the one of the fit
  SurfaceSetting(const FittedModel& fit,
                 const data::Table& table,
                 const std::map<std::string, double>& held,
                 std::stop_token stop = {});

  /// The estimates as a vector.
  /// \param log_sigma  of the internal sigma
  VectorXd coordinates(const SurfaceLayout& layout, double log_sigma) const;

  const FittedModel& fit;
  NonlinearModel model;
  VarianceModel variance;
  VectorXd estimate{};       ///< (p) of the coefficients that are not held
  CoefficientFrame frame{};  ///< whose units move the mean by about one residual sd
  VectorXd internal{};       ///< (m) estimates of the variance parameters
  double log_sigma = 0.0;    ///< of the internal sigma
};

/// F(x) = -log-likelihood. One surface belongs to one thread.
class LikelihoodSurface {
 public:
  explicit LikelihoodSurface(SurfaceLayout layout) : layout_(std::move(layout)) {}
  virtual ~LikelihoodSurface() = default;
  LikelihoodSurface(const LikelihoodSurface&) = delete;
  LikelihoodSurface& operator=(const LikelihoodSurface&) = delete;

  /// The value and, unless null, the exact gradient; infinite where there is none.
  virtual double value(const VectorXd& x, VectorXd* gradient) = 0;
  const SurfaceLayout& layout() const { return layout_; }
  /// The estimates.
  const VectorXd& optimum() const { return optimum_; }

 protected:
  SurfaceLayout layout_;
  VectorXd optimum_;
};

/// A new surface: for the methods of the marginal likelihood that likelihood; for lb, and gnls by
/// restricted likelihood or with correlated residuals, that of the model linear around the
/// estimates; for ols and gnls that of the nonlinear mean, with the weights of fitted values those
/// of the estimates.
std::unique_ptr<LikelihoodSurface> make_surface(const SurfaceSetting& setting);

/// Whether the likelihood of make_surface() is that of the model linear around the estimates.
bool is_linearized(const FittedModel& fit);
/// The name of the likelihood that make_surface returns for a fit, for messages.
std::string likelihood_in_words(const FittedModel& fit);

}  // namespace silvafit::fit
