// SPDX-License-Identifier: MIT
// The terms of one observation in a marginal likelihood and its derivatives, as expressions.
#pragma once

#include <string>
#include <vector>

#include "model/variance_weights.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The matrix K of second derivatives by the random effects in log|I + L'KL|.
enum class Curvature {
  kFull,        ///< of the joint density: Laplace's method
  kExpected,    ///< its expectation given the random effects: FOCE with interaction
  kFirstOrder,  ///< that of a mean linear in them with the residual variance at zero: FOCE
  /// That of penalized least squares, with weights that are held while the effects change:
  /// Lindstrom and Bates. It belongs to no likelihood.
  kHeldWeights,
};

/// Names of the variables in the terms; none can be a column's or parameter's name in a formula,
/// since all have a blank.
namespace term_names {
std::string log_sigma();
/// The value of a parameter without random effects.
std::string population(const std::string& parameter);
/// What a coefficient is multiplied by in its parameter.
std::string multiplier(Index coefficient);
/// Whether an observation is in a stratum of a quantity of the variance function.
std::string indicator(std::size_t quantity, Index stratum);
/// Element (i, j), i >= j, of the matrix M that is multiplied with K; see ObservationTerms.
std::string weight(Index i, Index j);
/// The weight of an observation that is held.
std::string held_weight();
/// A number of an observation that rows correlated with it determine; see ObservationTerms.
std::string adjoint(std::size_t k);
}  // namespace term_names

/// Terms of one observation with residual e = (y - f) / (sigma g) and l = log(sigma g): its
/// negative log density but for log(2 pi)/2, rho = l + e^2/2; c = tr(M K)/2 for a symmetric matrix
/// M; and their derivatives by coefficients, whose multipliers they include.
///
/// p coefficients; r of them are random in some grouping. There are m + 1 parameters of the
/// residual variance, the last of which is log sigma.
///
/// With held weights w = 1/(sigma g)^2 of another point, rho is w (y - f)^2 / 2, whose slope at the
/// weights' own point is `by_random`; `curvature` is the derivative of this slope with the weights
/// moving along.
///
/// Of correlated rows with correlation R, rho of a group is sum l + log|R|/2 + e'R^-1 e/2. With a =
/// R^-1 e held, its derivatives by b are the sums of those of l + a e, plus E'R^-1 E of second
/// order, E = de/db'. So are those of c with what stands for other rows held:
///
/// kFull: dc = d sum_i [tr(M d2(l + a e)/db db')/2 + u e/2 + G de/db],
///   u = R^-1 m, m = tr(M d2e/db db'), G = R^-1 E M.
/// kExpected and kFirstOrder: K = F'R^-1 F + S'QS with F = (df/db') / (sigma g), S = dl/db', and
///   Q = I + (R^-1 times R, by elements), the expected information of a normal distribution;
///   dc = d sum_i [G F + H S], G = R^-1 F M, H = Q S M.
/// kHeldWeights: rho = e'R^-1 e/2 of the model linear around the effects, l constant.
///
/// Adjoints are a, u, the r columns of G and the r columns of H.
struct ObservationTerms {
  data::Expression density = data::Expression::constant(0.0);  ///< rho
  std::vector<data::Expression> by_random{};                   ///< (r) d rho / d b
  std::vector<data::Expression> curvature{};      ///< lower triangle by columns of d2 rho / db db'
  std::vector<data::Expression> approximation{};  ///< the same of K; empty where it is the same
  /// (o) Coefficients whose derivatives are not those of the random effects on them; all where K
  /// depends on the population's mean.
  std::vector<Index> others{};
  std::vector<data::Expression> other_random{};  ///< (o x r by rows) d2 rho / d beta d b'
  /// With held weights: rho with the point's own weight, and this weight. Else empty.
  std::vector<data::Expression> own_weight{};

  std::vector<data::Expression> by_other{};           ///< (o) d rho / d beta + d c / d beta, b held
  std::vector<data::Expression> density_by_fixed{};   ///< (p) d rho / d beta
  std::vector<data::Expression> penalty_by_random{};  ///< (r) d c / d b
  std::vector<data::Expression> by_variance{};        ///< (m + 1) d rho + d c
  std::vector<data::Expression> density_by_variance{};  ///< (m + 1) d rho
  std::vector<data::Expression> variance_random{};      ///< (m + 1 x r by rows)

  // Of correlated rows; else empty.
  /// e; E (r); with an approximation F and S (r each).
  std::vector<data::Expression> states{};
  std::vector<data::Expression> held{};  ///< with held weights e with these
  /// Derivatives of e by others (o) and by parameters of the variance (scale parameters and
  /// log sigma); with kFull m.
  std::vector<data::Expression> wide_states{};
};

/// Those that a search for modes needs: without those of c and by single coefficients.
/// \param random  coefficients with random effects in any grouping, ascending
ObservationTerms mode_terms(const NonlinearModel& model,
                            const VarianceModel& variance,
                            Curvature curvature,
                            const std::vector<Index>& random);

/// All of them.
/// Source: the derivatives follow from the chain rule; Pinheiro and Bates 1995 (Laplace), Beal and
/// Sheiner 1992, Wang 2007, J. Pharmacokinet. Pharmacodyn. 34, 575 (FOCE); the expected information
/// of correlated rows from Mardia and Marshall 1984, Biometrika 71, 135-146.
ObservationTerms observation_terms(const NonlinearModel& model,
                                   const VarianceModel& variance,
                                   Curvature curvature,
                                   const std::vector<Index>& random);

}  // namespace silvafit::fit
