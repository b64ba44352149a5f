// SPDX-License-Identifier: MIT
// What the evidence of a least-squares fit means, in a sentence.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "least_squares/least_squares_polish.hpp"
#include "silvafit/fit/convergence.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Whether rounding alone can make such a sum of squares.
bool is_exact(const NonlinearModel& model, double sum_of_squares);

/// Whether the coefficients can be told apart somewhere, so that where they cannot it is the place.
bool is_identifiable(const NonlinearModel& model);

std::vector<std::string> names_of(const NonlinearModel& model,
                                  const std::vector<Eigen::Index>& coefficients);

/// Names of coefficients: "a", "a and b", "a, b and c".
std::string listed(const NonlinearModel& model, const std::vector<Eigen::Index>& coefficients);

/// \param exact  the model goes through all observations but for rounding
Convergence judge(const NonlinearModel& model, const NewtonPoint& point, bool exact);

/// Of fits that could not begin.
Convergence too_few_observations(const NonlinearModel& model);
Convergence no_start();

}  // namespace silvafit::fit
