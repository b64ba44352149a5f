// SPDX-License-Identifier: MIT
// Which of several modes of the random effects is the higher one.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "marginal_likelihood/marginal_likelihood.hpp"

namespace silvafit::fit {

/// Modes v of the random effects, b = L v.
struct Modes {
  Eigen::MatrixXd outer{};  ///< (s x C)
  Eigen::MatrixXd inner{};  ///< (q x G)
};

/// (C) -log of the joint density of observations and random effects of each cluster, but for a
/// constant: what a mode minimizes.
Eigen::VectorXd mode_objectives(const NonlinearModel& model,
                                const VarianceModel& variance,
                                const RandomPlaces& places,
                                const MarginalPoint& point,
                                const Modes& modes);

/// Takes over the modes of clusters where others are lower by more than rounding.
/// \param objectives  of the modes, and of the others
/// \return            whether there are any
bool take_lower(const NonlinearModel& model,
                const Modes& others,
                const Eigen::VectorXd& of_others,
                Modes& modes,
                Eigen::VectorXd& objectives);

/// Where else modes may be looked for: no effects, and each effect far to either side.
std::vector<Modes> other_starts(const Modes& modes);

}  // namespace silvafit::fit
