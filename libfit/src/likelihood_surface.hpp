// SPDX-License-Identifier: MIT
// The likelihood that a fit maximized, as a function of all of its parameters around the estimates.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "relative_factor.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/nonlinear_model.hpp"
#include "variance_weights.hpp"

namespace silvafit::fit {

/// Where the parameters are in a vector x of numbers of order one:
/// x = (beta / unit, factor of the coarser grouping, factor of the finer one, internal variance
/// parameters, log of the internal sigma). A factor is L of Psi = L L' with effects in units.
class SurfaceLayout {
 public:
  /// \param unit        (p) of each coefficient
  /// \param beta_count  p, or 0 where the likelihood is that of contrasts free of beta
  SurfaceLayout(const NonlinearModel& model,
                const VarianceModel& variance,
                Eigen::VectorXd unit,
                Eigen::Index beta_count);

  Eigen::Index size() const { return sigma_at() + 1; }
  Eigen::Index beta_count() const { return beta_; }
  Eigen::Index outer_at() const { return beta_; }
  Eigen::Index inner_at() const { return beta_ + outer_.parameter_count(); }
  Eigen::Index variance_at() const { return inner_at() + inner_.parameter_count(); }
  Eigen::Index variance_count() const { return variance_; }
  Eigen::Index sigma_at() const { return variance_at() + variance_; }

  const Eigen::VectorXd& unit() const { return unit_; }
  const RelativeFactor& factor(bool is_outer) const { return is_outer ? outer_ : inner_; }
  /// (q) units of the effects of a grouping.
  const Eigen::VectorXd& effect_unit(bool is_outer) const {
    return is_outer ? outer_unit_ : inner_unit_;
  }
  Eigen::Index factor_at(bool is_outer) const { return is_outer ? outer_at() : inner_at(); }
  /// The parameters of a grouping's factor.
  Eigen::VectorXd factor_part(const Eigen::VectorXd& x, bool is_outer) const {
    return x.segment(factor_at(is_outer), factor(is_outer).parameter_count());
  }
  Eigen::VectorXd variance_part(const Eigen::VectorXd& x) const {
    return x.segment(variance_at(), variance_);
  }
  /// The estimates of a fit as a vector.
  /// \param log_sigma  of the internal sigma
  Eigen::VectorXd coordinates(const FittedModel& fit,
                              const Eigen::VectorXd& estimate,
                              const Eigen::VectorXd& variance,
                              double log_sigma) const;

 private:
  Eigen::VectorXd unit_;
  Eigen::VectorXd outer_unit_;
  Eigen::VectorXd inner_unit_;
  Eigen::Index beta_ = 0;
  Eigen::Index variance_ = 0;
  RelativeFactor outer_;
  RelativeFactor inner_;
};

/// What surfaces of one fit share: the model bound to the data, without coefficients that are held.
struct SurfaceSetting {
  /// \throws UsageError if the fit did not converge, or the table is not the one it was made of
  SurfaceSetting(const FittedModel& fit, const data::Table& table);

  const FittedModel& fit;
  NonlinearModel model;
  VarianceModel variance;
  Eigen::VectorXd estimate{};  ///< (p) of the coefficients that are not held
  Eigen::VectorXd unit{};      ///< (p) what moves the mean by about one residual standard deviation
  Eigen::VectorXd internal{};  ///< (m) estimates of the variance parameters
  double log_sigma = 0.0;      ///< of the internal sigma
};

/// F(x) = -log-likelihood. One surface belongs to one thread.
class LikelihoodSurface {
 public:
  virtual ~LikelihoodSurface() = default;
  LikelihoodSurface() = default;
  LikelihoodSurface(const LikelihoodSurface&) = delete;
  LikelihoodSurface& operator=(const LikelihoodSurface&) = delete;

  /// The value and, unless null, the exact gradient; infinite where there is none.
  virtual double value(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) = 0;
  virtual const SurfaceLayout& layout() const = 0;
  /// The estimates.
  virtual const Eigen::VectorXd& optimum() const = 0;
};

/// A new surface: for the methods of the marginal likelihood that likelihood; for lb, and gnls by
/// restricted likelihood, that of the model linear around the estimates; for ols and gnls that of
/// the nonlinear mean, with the weights of fitted values those of the estimates.
std::unique_ptr<LikelihoodSurface> make_surface(const SurfaceSetting& setting);

/// In words for people, what make_surface gives for a fit.
std::string likelihood_in_words(const FittedModel& fit);

std::unique_ptr<LikelihoodSurface> make_marginal_surface(const SurfaceSetting& setting);
std::unique_ptr<LikelihoodSurface> make_linearized_surface(const SurfaceSetting& setting);
std::unique_ptr<LikelihoodSurface> make_least_squares_surface(const SurfaceSetting& setting);

}  // namespace silvafit::fit
