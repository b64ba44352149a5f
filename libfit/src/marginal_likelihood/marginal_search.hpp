// SPDX-License-Identifier: MIT
// The search of a maximum of a marginal likelihood: steps, certificate, the way out of saddles.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <string>

#include "likelihood/marginal_coordinates.hpp"
#include "likelihood/marginal_likelihood.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "model/variance_weights.hpp"
#include "optimization/curvature_certificate.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// Whether the likelihood has the true curvature at the modes, which need not be positive
/// elsewhere.
bool needs_curvature(Integration integration);

/// Fills in the fitted values of a fit, of which the estimates are known, and their deviations.
/// \param variance    of the model
/// \param scale       internal residual scale
/// \param parameters  of the variance, internal
void fill_in_fitted(const NonlinearModel& model,
                    const VarianceModel& variance,
                    double scale,
                    const Eigen::VectorXd& parameters,
                    MixedEffectsFit& fit);

/// Follows the exact gradient of a marginal likelihood from one or several fits; the best end is
/// its result.
class MarginalSearch {
 public:
  /// \param linearized  a fit near which the search begins; its coefficients give the units, unless
  ///   they are shared
  /// \param shared      the model's clusters among those of all ranks; null: they are all
  MarginalSearch(const NonlinearModel& model,
                 Integration integration,
                 const MarginalOptions& options,
                 const MixedEffectsFit& linearized,
                 const SharedClusters* shared = nullptr);

  /// Limits the iterations where other starts follow: near the maximum rounding can hide all
  /// descent, and a search that fails costs more than a start from scratch.
  void limit_search();

  /// Stops where it falls behind a log-likelihood that another search has reached.
  void stop_below(double known) { known_ = -known; }

  /// From a fit by another method.
  void try_fit(const MixedEffectsFit& fit);

  /// From the pooled fit with random effects of several spreads, until one converges.
  void try_pooled(const Eigen::VectorXd& beta);

  /// The log-likelihood at a fit by another method; NaN where it does not hold.
  double value_of(const MixedEffectsFit& fit);

  bool has_optimum() const { return std::isfinite(best_.value); }
  bool has_converged() const { return has_optimum() && best_.decrement <= kReachedDecrement; }

  /// Whether a unit of the search does not move the mean at a fit by about one residual standard
  /// deviation.
  bool is_out_of_scale(const MixedEffectsFit& fit) const;

  /// What ended the search short of a maximum, and where it would go.
  Obstacle obstacle() const;

  MixedEffectsFit result();

 private:
  /// Where a search ended.
  struct Optimum {
    Eigen::VectorXd x{};
    double value = std::numeric_limits<double>::infinity();
    double decrement = std::numeric_limits<double>::infinity();
    Eigen::VectorXd gradient{};
    Eigen::MatrixXd hessian{};
    bool is_blocked = false;  ///< whether only very short steps led on
    Modes modes{};
  };
  /// Squared distance to the optimum in standard errors at which a fit has converged, where
  /// rounding of gradients keeps a search from coming closer, as with random slopes on a covariate
  /// far from its origin.
  static constexpr double kReachedDecrement = 1e-6;

  /// \param spread  of the random effects, a share of the residuals' own
  void try_spread(const Eigen::VectorXd& beta, double residual_sd, double spread);

  Eigen::VectorXd coordinates_of(const MixedEffectsFit& fit) const;

  Eigen::Index outer_count() const {
    return static_cast<Eigen::Index>(likelihood_.places().outer.size());
  }
  Eigen::Index inner_count() const {
    return static_cast<Eigen::Index>(likelihood_.places().inner.size());
  }

  Eigen::MatrixXd outer_of(const MixedEffectsFit& fit) const;
  /// The modes that a fit by another method has at x.
  Modes modes_of(const MixedEffectsFit& fit, const Eigen::VectorXd& x) const;

  /// What ended the search short of a maximum.
  Obstacle ended_by() const;

  /// The parameter that moves most on the way to where the quadratic around the best point has its
  /// minimum, by what it does to the mean.
  std::string moving() const;

  bool is_exhausted() const { return is_hopeless_ || evaluations_ >= most_evaluations_; }

  /// Notes whether the evaluations that are left would lead to the known maximum, at the pace of
  /// the last ones: as many as a first Hessian and some steps take.
  void watch_pace(double lowest);

  double value_at(const Eigen::VectorXd& x, Eigen::VectorXd* gradient);

  void run(const Eigen::VectorXd& start, Modes modes);

  /// Looks elsewhere for modes, which a search follows from one point to the next and may have
  /// lost, and begins with the highest ones from now on.
  bool finds_higher_modes(const Optimum& optimum);

  Optimum searched(const Eigen::VectorXd& start);

  /// A point below a saddle, along its direction of negative curvature; nothing if there is none.
  Eigen::VectorXd lower_point(const Optimum& optimum, const CurvatureCertificate& certificate);

  /// If the covariance is singular although the likelihood increases towards the interior, a point
  /// inside; else nothing. At the boundary the gradient is zero by symmetry.
  Eigen::VectorXd inside_of(const Optimum& optimum);

  /// The fixed effects' block of the inverse of the observed information.
  Eigen::MatrixXd fixed_covariance() const;

  const NonlinearModel& model_;
  const SharedClusters* shared_;
  const MarginalOptions& options_;
  Integration integration_;
  VarianceModel variance_;
  MarginalLikelihood likelihood_;
  MarginalCoordinates coordinates_;
  Optimum best_;
  int rounds_ = 6;        ///< of a search and its certificate
  int steps_ = 100;       ///< of a search within a round
  int short_steps_ = 10;  ///< in a row that end a search
  int most_evaluations_ = 500 + 50 * static_cast<int>(coordinates_.layout().size());
  int evaluations_ = 0;
  double known_ = std::numeric_limits<double>::infinity();  ///< value of a minimum known elsewhere
  double last_look_ = std::numeric_limits<double>::infinity();
  int next_look_ = 0;
  bool is_hopeless_ = false;
  int outside_ = 0;  ///< evaluations at points where the likelihood does not hold
};

}  // namespace silvafit::fit
