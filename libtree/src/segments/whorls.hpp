// SPDX-License-Identifier: MIT
// How many first-order branches a tree bears, and at which heights.
#pragma once

#include <vector>

#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Branches that start at one height.
struct Whorl {
  double base_m = 0.0;
  int branches = 0;
};

/// The whorls of a tree from the crown base up; the lowest stands at the crown base exactly. A
/// spiral's branches are whorls of one.
///
/// Where the age is known and the preset has the equations, there are as many living branches as
/// these say. Where it has yearly whorls too, these stand on the shoots of as many years as the
/// crown's length holds, all shoots being of equal length; dead branches are shed from the bottom
/// up, below the crown base.
/// \param bound  branches that are planned elsewhere and count among the living ones
/// \param notes  gains an entry where an equation was left or not followed
std::vector<Whorl> plan_whorls(const TreeShape& shape,
                               const Preset& preset,
                               int bound,
                               Random& random,
                               std::vector<Note>& notes);

}  // namespace silvafit::tree
