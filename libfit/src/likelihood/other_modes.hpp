// SPDX-License-Identifier: MIT
// Comparison of several modes of the random effects.
#pragma once

#include <vector>

#include "likelihood/marginal_likelihood.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Replaces the modes of clusters by other ones whose objective is lower by more than rounding.
/// \param objectives  the minimized objectives: of the modes, and of the others
/// \return            whether a mode was replaced
bool take_lower(const EffectLayout& layout,
                const Eigen::VectorXd& others,
                const Eigen::VectorXd& of_others,
                Eigen::VectorXd& modes,
                Eigen::VectorXd& objectives);

/// Further starts of the search for modes: no effects, and each effect far to either side.
std::vector<Eigen::VectorXd> other_starts(const EffectLayout& layout);

}  // namespace silvafit::fit
