// SPDX-License-Identifier: MIT
// Degrees of freedom of the t tests of fixed effects, as in R's nlme.
#pragma once

#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

struct FixedFreedom {
  VectorXd of_tests{};  ///< (p) denominator degrees of freedom of each coefficient
  /// Number of coefficients, without an intercept, that are estimated between the groups of each
  /// grouping, the coarsest first.
  std::vector<int> coefficients_between{};
};

/// The degrees of freedom of the fixed effects.
///
/// A coefficient belongs to the finest stratum in which its column of the Jacobian varies: within
/// the groups (of which there are G), between the groups of a coarser one (S), or between the
/// coarsest groups only. The degrees of freedom of a stratum are the difference of its number of
/// units from that of the stratum above (N - G, G - S, S; without random effects N), less one for
/// each coefficient in it. A column that is constant in all data is an intercept: it uses one
/// degree of freedom of the coarsest stratum and itself gets the largest number; without one, the
/// finer strata get one more.
/// \param jacobian  (N x p) df/d coefficient in the model's order
/// \param units     how many groups each grouping has, the coarsest first, and the number of
///   observations, where the model is a sample of the data; empty: those of the model
/// Source: Pinheiro and Bates 2000, section 2.4.2, and getFixDF of nlme 3.1.
FixedFreedom fixed_freedom(const NonlinearModel& model,
                           const Eigen::Ref<const MatrixXd>& jacobian,
                           const std::vector<double>& units = {});

/// The same with the Jacobian at given coefficients. Their values hardly matter, because only the
/// strata in which its columns vary are used.
FixedFreedom fixed_freedom_at(const NonlinearModel& model,
                              const VectorXd& coefficients,
                              const std::vector<double>& units = {});

}  // namespace silvafit::fit
