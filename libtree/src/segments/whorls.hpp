// SPDX-License-Identifier: MIT
// Numbers of first-order branches of a tree, and their heights.
#pragma once

#include <vector>

#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Branches that start at one height.
struct Whorl {
  double base_m = 0.0;
  int branches = 0;
};

/// The whorls of a tree from the crown base up; the lowest is exactly at the crown base. A
/// spiral's branches are whorls of one.
///
/// If the age is known and the preset has the equations, the number of living branches is that of
/// the equations. With yearly whorls, these are on the shoots of as many years as the crown's
/// length contains, all shoots being of equal length; dead branches are shed from the bottom up,
/// below the crown base.
/// \param bound  branches that are planned elsewhere and count as living ones
/// \param notes  gets an entry if an equation was left or not followed
std::vector<Whorl> plan_whorls(const TreeShape& shape,
                               const Preset& preset,
                               int bound,
                               Random& random,
                               std::vector<Note>& notes);

}  // namespace silvafit::tree
