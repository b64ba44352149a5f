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
/// A number of an observation that rows correlated with it determine; see CorrelatedTerms.
std::string adjoint(std::size_t k);
}  // namespace term_names

/// What the search for modes needs of one observation: rho = log(sigma g) + (y - f)^2 /
/// (2 sigma^2 g^2), the negative log density but for log(2 pi)/2, and its derivatives by
/// coefficients, whose multipliers they include.
///
/// p coefficients; r of them are random in some grouping. With held weights w = 1/(sigma g)^2 of
/// another point, rho is w (y - f)^2 / 2, whose slope at the weights' own point is `by_random`;
/// `curvature` is the derivative of this slope with the weights moving along.
struct ModeTerms {
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
};

/// \param random  coefficients with random effects in any grouping, ascending
ModeTerms mode_terms(const NonlinearModel& model,
                     const VarianceModel& variance,
                     Curvature curvature,
                     const std::vector<Index>& random);

/// Terms of one observation in a marginal likelihood: rho, and c = tr(M K)/2 for a symmetric matrix
/// M. There are m + 1 parameters of the residual variance, the last of which is log sigma.
struct ObservationTerms : ModeTerms {
  std::vector<data::Expression> by_other{};           ///< (o) d rho / d beta + d c / d beta, b held
  std::vector<data::Expression> density_by_fixed{};   ///< (p) d rho / d beta
  std::vector<data::Expression> penalty_by_random{};  ///< (r) d c / d b
  std::vector<data::Expression> by_variance{};        ///< (m + 1) d rho + d c
  std::vector<data::Expression> density_by_variance{};  ///< (m + 1) d rho
  std::vector<data::Expression> variance_random{};      ///< (m + 1 x r by rows)
};

/// \param random  coefficients with random effects in any grouping, ascending
/// Source: the derivatives follow from the chain rule; Pinheiro and Bates 1995 (Laplace), Beal and
/// Sheiner 1992, Wang 2007, J. Pharmacokinet. Pharmacodyn. 34, 575 (FOCE).
ObservationTerms observation_terms(const NonlinearModel& model,
                                   const VarianceModel& variance,
                                   Curvature curvature,
                                   const std::vector<Index>& random);

}  // namespace silvafit::fit
