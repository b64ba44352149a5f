// SPDX-License-Identifier: MIT
// Least squares in the nonlinear coefficients only, with the linear ones solved for.
#pragma once

#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The coefficients of a model in two parts: `linear` enter the mean jointly linearly.
struct CoefficientSplit {
  std::vector<Index> linear{};
  std::vector<Index> nonlinear{};
};

/// A largest jointly linear set, found greedily.
CoefficientSplit split_coefficients(const NonlinearModel& model);

/// A model as a function of its q nonlinear coefficients: the best linear coefficients belong to
/// each of their values.
///
/// Source: Golub and Pereyra 1973, SIAM Journal on Numerical Analysis 10, 413-432; the Jacobian
/// with Kaufman's simplification (1975, BIT 15, 49-57), which leaves the gradient exact.
/// Not thread safe: evaluations share scratch memory. The model must outlive it.
class ProjectedModel {
 public:
  explicit ProjectedModel(const NonlinearModel& model);

  const NonlinearModel& model() const { return model_; }
  const CoefficientSplit& split() const { return split_; }
  Index size() const { return static_cast<Index>(split_.nonlinear.size()); }

  /// The nonlinear ones among all coefficients.
  VectorXd nonlinear_part(const VectorXd& coefficients) const;

  /// Evaluates at nonlinear values; afterwards coefficients() and residuals() are valid.
  /// \return  false where the mean is not finite
  bool evaluate(const VectorXd& nonlinear);
  /// (N x q) derivative of the residuals y - f after evaluate().
  /// \return  false where it is not finite
  bool evaluate_jacobian(MatrixXd& jacobian);

  /// (p) all coefficients, the linear ones solved for.
  const VectorXd& coefficients() const { return coefficients_; }
  const VectorXd& residuals() const { return residuals_; }

 private:
  bool solve_linear();

  const NonlinearModel& model_;
  CoefficientSplit split_;
  NonlinearModel::Workspace workspace_;
  VectorXd coefficients_;
  VectorXd residuals_;
  VectorXd mean_;
  MatrixXd jacobian_;
  MatrixXd basis_;  ///< orthonormal, of the space that the linear coefficients span
};

}  // namespace silvafit::fit
