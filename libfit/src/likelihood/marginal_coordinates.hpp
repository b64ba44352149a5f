// SPDX-License-Identifier: MIT
// The parameters of a marginal likelihood as one vector of numbers of order one.
#pragma once

#include "likelihood/marginal_likelihood.hpp"
#include "likelihood/surface_layout.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Conversion between points of the likelihood and vectors x in the layout of SurfaceLayout.
class MarginalCoordinates {
 public:
  /// \param frame  of the coefficients; one unit moves the mean by about one residual standard
  ///   deviation
  MarginalCoordinates(const NonlinearModel& model,
                      const VarianceModel& variance,
                      const CoefficientFrame& frame)
      : model_(model), layout_(model, variance, frame, frame.beta.cols()) {}

  const SurfaceLayout& layout() const { return layout_; }
  MarginalPoint point(const VectorXd& x) const;
  VectorXd gradient(const VectorXd& x, const MarginalValue& value) const;
  /// \param observation  beta without those that have random effects only
  /// \param covariances  Psi of each term, in the coefficients' own units
  VectorXd coordinates(const ObservationPoint& observation,
                       const std::vector<MatrixXd>& covariances) const;
  /// (q x groups) of each term: the modes v of random effects b = L v, as far as L can represent
  /// them.
  /// \param effects  in the coefficients' own units
  std::vector<MatrixXd> spherical(const VectorXd& x, const std::vector<MatrixXd>& effects) const;
  /// x with a larger covariance of a term in one direction of the frame.
  VectorXd widened(const VectorXd& x,
                   std::size_t term,
                   const VectorXd& direction,
                   double size) const;
  /// The covariance of a term in the frame.
  MatrixXd scaled_covariance(const VectorXd& x, std::size_t term) const;

 private:
  const NonlinearModel& model_;
  SurfaceLayout layout_;
};

}  // namespace silvafit::fit
