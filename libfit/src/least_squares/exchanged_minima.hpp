// SPDX-License-Identifier: MIT
// Minima at which terms of the formula are exchanged.
#pragma once

#include <vector>

#include "least_squares/periodic_coefficients.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// An exchange of coefficients: coefficient i becomes offset[i] + factor[i] * coefficient from[i].
struct Exchange {
  std::vector<Index> from{};
  VectorXd factor{};  ///< 1 or -1
  VectorXd offset{};

  VectorXd of(const VectorXd& coefficients) const;
  /// Whether a phase is shifted.
  bool is_shift() const { return (factor.array() > 0.0 && offset.array() != 0.0).any(); }
};

/// Exchanges of coefficients that leave the mean unchanged.
///
/// The two terms of a biexponential, the rates of absorption and elimination, and the two
/// asymptotes of a logistic curve (with the sign of its slope changed) can be exchanged without
/// changing a fit without random effects. With random effects on one of them the fits differ; if
/// the groups of a model with random effects would not differ, the exchange is left out.
/// Tried are exchanges of up to four pairs, of two pairs of nine or ten coefficients, and of one
/// pair with a change of sign, or of the share f of f*A + (1 - f)*B to 1 - f. If the period of a
/// sine has random effects, its phase is shifted by half periods.
/// \param minimum  (p) coefficients of a fit; there are no exchanges of more than ten
/// \param varying  numbers of the coefficients with random effects
std::vector<Exchange> exchanges(const NonlinearModel& model,
                                const VectorXd& minimum,
                                const std::vector<Index>& varying);

/// The coefficients after each exchange.
std::vector<VectorXd> exchanged_minima(const NonlinearModel& model, const VectorXd& minimum);

/// All points of the same mean that are known: after each exchange, and after an exchange of two
/// coefficients to which the others adapt, as the volume V of a compartment becomes V ke/ka.
std::vector<VectorXd> points_of_same_mean(const NonlinearModel& model, const VectorXd& point);

/// Of a minimum and those with the same mean after an exchange, the one nearest to a start.
/// \param start  (p)
VectorXd nearest_minimum(const NonlinearModel& model,
                         const VectorXd& minimum,
                         const VectorXd& start);

/// The same mean with each phase of a sine as near to another one as shifts by half periods, with a
/// change of sign of another coefficient, allow.
/// \param to  (p) coefficients with the other phases
VectorXd with_nearest_phases(const NonlinearModel& model,
                             const VectorXd& coefficients,
                             const VectorXd& to);

/// The same mean with the signs of other coefficients, as far as half periods of phases change
/// them: -A*cos(x - t) is A*cos(x - t + pi). \param to  (p) coefficients with the signs
VectorXd with_signs_of(const NonlinearModel& model,
                       const VectorXd& coefficients,
                       const VectorXd& to);

/// The same mean with each phase of a sine near the observations. A descent that passes a zero
/// amplitude, where the phase is not determined, may end many periods away.
VectorXd with_usual_phases(const NonlinearModel& model, const VectorXd& coefficients);

/// Minima with two locations on the axis of a column exchanged, to which a descent adapts the other
/// coefficients.
std::vector<VectorXd> exchanged_locations(const NonlinearModel& model, const VectorXd& minimum);

}  // namespace silvafit::fit
