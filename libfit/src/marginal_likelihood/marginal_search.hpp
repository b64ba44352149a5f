// SPDX-License-Identifier: MIT
// The search of a maximum of a marginal likelihood: steps, certificate, steps from saddle points.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "likelihood/marginal_coordinates.hpp"
#include "likelihood/marginal_likelihood.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "model/variance_weights.hpp"
#include "optimization/curvature_certificate.hpp"
#include "optimization/quasi_newton.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// Whether the likelihood uses the true curvature at the modes, which may be negative elsewhere.
bool needs_curvature(Method method);

/// Computes the fitted values of a fit with known estimates, and their standard deviations.
/// \param variance    of the model
/// \param scale       internal residual scale
/// \param parameters  of the variance, internal
void fill_in_fitted(const NonlinearModel& model,
                    const VarianceModel& variance,
                    double scale,
                    const VectorXd& parameters,
                    MixedEffectsFit& fit);

/// Maximizes a marginal likelihood with its exact gradient from one or several fits; the best end
/// is the result.
class MarginalSearch {
 public:
  /// \param near    (p) coefficients near which the search begins; they give the units, unless
  /// these
  ///   are shared
  /// \param shared  the model's clusters among those of all ranks; null: they are all
  MarginalSearch(const NonlinearModel& model,
                 Method method,
                 const MixedEffectsOptions& options,
                 const VectorXd& near,
                 const SharedClusters* shared = nullptr);

  /// Limits the iterations if other starts follow: near the maximum the descent may be below
  /// rounding, and a failing search costs more than a new start.
  void limit_search();

  /// Stops the search if it will not reach a log-likelihood that another search has reached.
  void stop_below(double known) { known_ = -known; }

  /// From a fit by another method.
  void try_fit(const MixedEffectsFit& fit);

  /// From the pooled fit with random effects of several spreads, until one converges; a limited
  /// search, until one ends at a valid point.
  void try_pooled(const VectorXd& beta);

  /// The log-likelihood at a fit by another method; NaN if it is not valid there.
  double value_of(const MixedEffectsFit& fit);

  bool has_optimum() const { return std::isfinite(best_.value); }
  bool has_converged() const { return has_optimum() && best_.decrement <= kReachedDecrement; }

  /// Whether a unit of the search changes the mean at a fit by much more or less than one residual
  /// standard deviation.
  bool is_out_of_scale(const MixedEffectsFit& fit) const;

  /// The reason why the search did not reach a maximum, and its direction.
  Obstacle obstacle() const;

  MixedEffectsFit result();

  /// Sets the covariance of the coefficients of a converged fit to that by the observed information
  /// there, more accurate than that of result(), which is from the Hessian of the search.
  /// With kinks that random effects move there may be none; then it is by the expected one.
  void compute_errors(MixedEffectsFit& fit);

  int evaluations() const { return evaluations_; }

 private:
  /// The end of a search.
  struct Optimum {
    VectorXd x{};
    double value = kInfinity;
    double decrement = kInfinity;
    VectorXd gradient{};
    MatrixXd hessian{};
    bool is_blocked = false;  ///< whether only very short steps were possible
    VectorXd modes{};
    MatrixXd kinks{};  ///< normals of kinks at x
  };
  /// Newton decrement at which a fit has converged if rounding of gradients prevents a smaller one,
  /// as with random slopes on a covariate far from its origin.
  static constexpr double kReachedDecrement = 1e-6;

  /// \param spread  of the random effects, relative to the residual standard deviation
  void try_spread(const VectorXd& beta, double residual_sd, double spread);

  VectorXd coordinates_of(const MixedEffectsFit& fit) const;

  /// The modes that a fit by another method has at x.
  VectorXd modes_of(const MixedEffectsFit& fit, const VectorXd& x) const;

  /// The reason why the search did not reach a maximum.
  Obstacle ended_by() const;

  /// The parameter with the largest effect on the mean in the step to the minimum of the quadratic
  /// around the best point.
  std::string moving() const;

  bool is_exhausted() const { return is_too_slow_ || evaluations_ >= most_evaluations_; }

  /// Checks whether the remaining evaluations are sufficient to reach the known maximum, at the
  /// progress of the last ones (as many as a first Hessian and some steps need).
  void check_progress(double lowest);

  double value_at(const VectorXd& x, VectorXd* gradient);

  void run(const VectorXd& start, VectorXd modes);

  /// Searches modes from further starts, because a search that follows them from point to point may
  /// have lost the highest ones; the next evaluations start from the highest ones.
  bool finds_higher_modes(const Optimum& optimum);

  Optimum searched(const VectorXd& start);

  /// Whether the likelihood has kinks: of the formula, or in the range of a correlation.
  bool has_kinks() const;

  /// If the search is stuck at kinks, the minimum there.
  void settle_at_kinks(const SmoothFunction& function, Optimum& optimum) const;

  /// A point below a saddle point, along its direction of negative curvature; no value if there is
  /// none.
  VectorXd lower_point(const Optimum& optimum, const CurvatureCertificate& certificate);

  /// If the covariance is singular although the likelihood increases towards the interior, a point
  /// inside; else no value. At the boundary the gradient is zero by symmetry.
  VectorXd inside_of(const Optimum& optimum);

  /// The Hessian at a fit; no value where the likelihood is not valid.
  std::optional<MatrixXd> accurate_hessian(const MixedEffectsFit& fit);

  /// (N x p) slopes of the population's curve by the coordinates of the coefficients.
  MatrixXd curve_slopes(const VectorXd& x) const;

  /// Sets the covariance of the coefficients and the number of them that are identifiable.
  void set_covariance(const MatrixXd& hessian, MixedEffectsFit& fit) const;

  const NonlinearModel& model_;
  const SharedClusters* shared_;
  const MixedEffectsOptions& options_;
  Method method_;
  VarianceModel variance_;
  MarginalLikelihood likelihood_;
  MarginalCoordinates coordinates_;
  Optimum best_;
  int rounds_ = 6;        ///< searches with their certificates
  int steps_ = 100;       ///< of a single search
  int short_steps_ = 10;  ///< in a row that end a search
  int most_evaluations_ = 500 + 50 * static_cast<int>(coordinates_.layout().size());
  int evaluations_ = 0;
  double known_ = kInfinity;  ///< value of a known minimum
  double value_at_last_check_ = kInfinity;
  int next_check_ = 0;
  bool is_too_slow_ = false;
  bool is_limited_ = false;
  int outside_ = 0;  ///< evaluations at points where the likelihood is not valid
};

}  // namespace silvafit::fit
