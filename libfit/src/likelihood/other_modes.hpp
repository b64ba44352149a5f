// SPDX-License-Identifier: MIT
// Which of several modes of the random effects is the higher one.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "likelihood/marginal_likelihood.hpp"

namespace silvafit::fit {

/// Takes over the modes of clusters where others are lower by more than rounding.
/// \param objectives  what modes minimize: of the modes, and of the others
/// \return            whether there are any
bool take_lower(const NonlinearModel& model,
                const Modes& others,
                const Eigen::VectorXd& of_others,
                Modes& modes,
                Eigen::VectorXd& objectives);

/// Where else modes may be looked for: no effects, and each effect far to either side.
std::vector<Modes> other_starts(const Modes& modes);

}  // namespace silvafit::fit
