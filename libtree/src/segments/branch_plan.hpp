// SPDX-License-Identifier: MIT
// Whorls of first-order branches, their start and their direction.
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

/// A straight line from the stem's axis to the crown curve.
struct PlannedBranch {
  double base_m = 0.0;      ///< height on the axis
  double angle_rad = 0.0;   ///< from the upward vertical, in (0, pi/2]
  Point outward{};          ///< horizontal, of length 1
  double distance_m = 0.0;  ///< of the tip from the axis
  bool is_limb = false;     ///< the stem divides into this one and others

  double length_m() const;
  Point tip() const;
};

/// The branches of a tree from the crown base up, and at the end the four at the measured crown
/// radii.
/// \param notes  gets an entry if a branch-count equation was left or not followed
std::vector<PlannedBranch> plan_branches(const TreeShape& shape,
                                         const Crown& crown,
                                         const Preset& preset,
                                         Random& random,
                                         std::vector<Note>& notes);

/// An angle [rad] from a normal distribution truncated to the interval: its mean
/// is the middle, its standard deviation a quarter of the interval, so that it is truncated at two
/// standard deviations.
///
/// Interpolated linearly in a table of quantiles with steps of 1/1024, which
/// is ten times as fast as drawing normals and exact to a thousandth of the interval.
double drawn_angle(Random& random, double low_deg, double high_deg);

}  // namespace silvafit::tree
