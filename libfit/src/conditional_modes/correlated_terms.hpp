// SPDX-License-Identifier: MIT
// The terms of one observation whose residual is correlated with others, as expressions.
#pragma once

#include <vector>

#include "conditional_modes/observation_terms.hpp"
#include "silvafit/data/expression.hpp"

namespace silvafit::fit {

/// For residuals e = (y - f) / (sigma g) with correlation R, of a group
///   rho = sum l + log|R|/2 + e'R^-1 e/2,   l = log(sigma g).
/// With a = R^-1 e held, its derivatives by b are the sums of those of l + a e, plus E'R^-1 E of
/// second order, E = de/db'. So are those of c = tr(M K)/2 with what stands for other rows held:
///
/// kFull: K is the second derivative of rho;
///   dc = d sum_i [tr(M d2(l + a e)/db db')/2 + u e/2 + G de/db],
///   u = R^-1 m, m = tr(M d2e/db db'), G = R^-1 E M.
/// kExpected and kFirstOrder: K = F'R^-1 F + S'QS with F = (df/db') / (sigma g), S = dl/db', and
///   Q = I + (R^-1 times R, by elements), the expected information of a normal distribution;
///   dc = d sum_i [G F + H S], G = R^-1 F M, H = Q S M.
/// kHeldWeights: rho = e'R^-1 e/2 of the model linear around the effects, l constant.
///
/// Adjoints are a, u, the r columns of G and the r columns of H.
struct CorrelatedTerms : ObservationTerms {
  /// e; E (r); with an approximation F and S (r each).
  std::vector<data::Expression> states{};
  std::vector<data::Expression> held{};  ///< with held weights e with these; else empty
  /// Derivatives of e by others (o) and by parameters of the variance (scale parameters and
  /// log sigma); with kFull m.
  std::vector<data::Expression> wide_states{};
};

/// Source of the expected information: Mardia and Marshall 1984, Biometrika 71, 135-146.
/// \param random  coefficients with random effects in any grouping, ascending
CorrelatedTerms correlated_terms(const NonlinearModel& model,
                                 const VarianceModel& variance,
                                 Curvature curvature,
                                 const std::vector<Index>& random);

}  // namespace silvafit::fit
