// SPDX-License-Identifier: MIT
// The turtle that draws a string of modules, and the skeleton of the drawing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/tree/lsystem.hpp"
#include "silvafit/tree/point.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// The orientation of a turtle: three orthogonal directions, up = heading x left.
///
/// It starts upright: heading up, left to the west, its own up to the south, as seen from there.
/// Turns have the direction of their names: left towards `left`, down away from `up`, and a roll to
/// the left lowers the left side. Angles in radians.
/// Source: Prusinkiewicz and Lindenmayer 1990, The Algorithmic Beauty of Plants, section 1.5.
struct TurtleFrame {
  Point heading{0.0, 0.0, 1.0};
  Point left{-1.0, 0.0, 0.0};
  Point up{0.0, -1.0, 0.0};

  void turn_left(double angle_rad);
  void pitch_down(double angle_rad);
  void roll_left(double angle_rad);
  /// Rolls until `left` is horizontal and `up` not below; does nothing if the heading is
  /// vertical.
  void level();
  /// Turns the heading towards a direction, by the elasticity times the sine of the angle between
  /// them (ABOP, section 2.2).
  void bend_towards(Point direction, double elasticity);
};

/// The result of `F`: a straight piece of wood.
struct DrawnSegment {
  Point to{};
  double width = 0.0;        ///< diameter, in units of length
  std::uint32_t before = 0;  ///< the segment at whose end it starts, or kNone at the root
  std::uint32_t line = 0;    ///< index of its line
};

/// The segments between two brackets: of one branch without its branches.
struct DrawnLine {
  Point from{};
  std::uint32_t before = 0;  ///< the segment at whose end it starts, or kNone at the root
  std::uint32_t first = 0;   ///< its first segment
  std::uint32_t last = 0;    ///< its last segment
  bool has_apex = false;     ///< an apex or bud is at its end
};

/// A drawn leaf or bud, or the outline between { and }.
struct DrawnLeaf {
  LeafSite site{};  ///< its axis is not set
  std::uint32_t line = 0;
  bool is_bud = false;
};

/// The result of a turtle's drawing.
struct Drawing {
  static constexpr std::uint32_t kNone = 0xffffffff;

  std::vector<DrawnSegment> segments{};
  std::vector<DrawnLine> lines{};  ///< parents come before their children
  std::vector<DrawnLeaf> leaves{};
};

/// \throws InputError if brackets do not match, branches are nested too deeply, it takes too long,
/// or a coordinate is not finite
Drawing draw(const ModuleString& string,
             const TurtleSettings& settings,
             const std::string& file,
             const LsystemLimits& limits = {});

/// The axes of a drawing. A line is an axis; lines that start on it are its branches and have the
/// next order. A line that ends without an apex where others start continues in the thickest of
/// them, of equally thick ones in the straightest. The stem continues to the top: of equally thick
/// ones, in the one that reaches highest.
///
/// A point has half the width of the segment that starts there; tips have width 0.
/// \param bud_grade  grade of the leaf sites for buds; without it buds are omitted
/// \throws InputError if nothing is drawn
Skeleton skeleton_of(const Drawing& drawing,
                     const std::string& file,
                     std::optional<std::uint32_t> bud_grade = {});

}  // namespace silvafit::tree
