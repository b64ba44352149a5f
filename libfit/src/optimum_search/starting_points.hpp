// SPDX-License-Identifier: MIT
// Coefficients from which the search of a mixed model begins.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "silvafit/fit/least_squares.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

struct StartingPoint {
  Eigen::VectorXd coefficients{};  ///< (p)
  std::string origin{};            ///< "least squares", "start values", ... for reports
};

struct StartingPointOptions {
  std::vector<Eigen::VectorXd> given{};  ///< (p) each: the user's, which come first
  int spread = 0;                        ///< further points, spread around the others
};

/// Points that may lead to different maxima of the likelihood, the most promising first, no two at
/// the same place: values that were given; the pooled least-squares fit; coefficients that fit the
/// pooled data as well with terms exchanged, or nearly as well; medians of least-squares fits to
/// single groups; the fit of the formula solved for its coefficients, as h = d^2/(a + b d) is
/// linear in d^2/h; and spread points.
/// \param pooled  the least-squares fit, with its other minima
std::vector<StartingPoint> starting_points(const NonlinearModel& model,
                                           const LeastSquaresFit& pooled,
                                           const StartingPointOptions& options = {});

}  // namespace silvafit::fit
