// SPDX-License-Identifier: MIT
// The turtle that draws a string of modules, and the skeleton that it leaves.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/tree/lsystem.hpp"
#include "silvafit/tree/point.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Where a turtle looks: three directions at right angles, up = heading x left.
///
/// It begins upright: heading up, left to the west, its own up to the south, as if seen from there.
/// Turns go the way that they are named: left towards `left`, down away from `up`, and a roll to
/// the left lowers the left side. Angles in radians.
/// Source: Prusinkiewicz and Lindenmayer 1990, The Algorithmic Beauty of Plants, section 1.5.
struct TurtleFrame {
  Point heading{0.0, 0.0, 1.0};
  Point left{-1.0, 0.0, 0.0};
  Point up{0.0, -1.0, 0.0};

  void turn_left(double angle_rad);
  void pitch_down(double angle_rad);
  void roll_left(double angle_rad);
  /// Rolls until `left` is horizontal and `up` not below; does nothing where the heading is
  /// upright.
  void level();
  /// Turns the heading towards a direction, by the elasticity times the sine of the angle between
  /// them (ABOP, section 2.2).
  void bend_towards(Point direction, double elasticity);
};

/// What `F` draws: a straight piece of wood.
struct DrawnSegment {
  Point to{};
  double width = 0.0;        ///< diameter, in units of length
  std::uint32_t before = 0;  ///< the segment at whose end it begins, or kNone at the root
  std::uint32_t line = 0;    ///< which line it is a part of
};

/// The segments between two brackets: of one branch and not of its branches.
struct DrawnLine {
  Point from{};
  std::uint32_t before = 0;  ///< the segment at whose end it begins, or kNone at the root
  std::uint32_t first = 0;   ///< its first segment
  std::uint32_t last = 0;    ///< its last segment
  bool has_apex = false;     ///< an apex or bud stands at its end
};

/// A drawn leaf or bud, or the outline between { and }.
struct DrawnLeaf {
  LeafSite site{};  ///< its axis is not set
  std::uint32_t line = 0;
  bool is_bud = false;
};

/// What a turtle draws, as it draws it.
struct Drawing {
  static constexpr std::uint32_t kNone = 0xffffffff;

  std::vector<DrawnSegment> segments{};
  std::vector<DrawnLine> lines{};  ///< those that bear come before those that are borne
  std::vector<DrawnLeaf> leaves{};
};

/// \throws InputError if brackets do not match, branches are nested too deeply, it takes too long,
/// or a coordinate is not finite
Drawing draw(const ModuleString& string,
             const TurtleSettings& settings,
             const std::string& file,
             const LsystemLimits& limits = {});

/// The axes of a drawing. A line is an axis; it bears the lines that begin on it, which have the
/// next order. A line that ends without an apex where others begin goes on in the thickest of them,
/// of equally thick ones in the straightest, and so the stem goes on to the top: of equally thick
/// ones, in that which reaches highest.
///
/// A point has half the width of the segment that begins there; tips have none.
/// \param bud_grade  grade of the leaf sites that are made of buds; buds are left out without one
/// \throws InputError if nothing is drawn
Skeleton skeleton_of(const Drawing& drawing,
                     const std::string& file,
                     std::optional<std::uint32_t> bud_grade = {});

}  // namespace silvafit::tree
