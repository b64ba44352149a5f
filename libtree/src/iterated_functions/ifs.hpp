// SPDX-License-Identifier: MIT
// Trees from iterated function systems: a few maps make a tree of smaller copies of itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "segments/affine_map.hpp"
#include "silvafit/tree/builder.hpp"

namespace silvafit::tree {

/// A map that places a smaller copy of the whole tree on its trunk. All maps shrink space.
///
/// The trunk is the line from the origin to (0, 0, 1). Given by position: the copy starts on the
/// trunk at a proportion of its length, leans by an angle towards an azimuth and is rotated about
/// its own trunk; or given by a matrix.
struct IfsCopy {
  AffineMap map{};
  double scale = 0.5;            ///< of the copy's trunk
  double probability = 1.0;      ///< that it bears a leaf; those of all maps add up to 1
  double thickness = 0.5;        ///< radius of the copy's trunk relative to the trunk's
  bool continues = false;        ///< the copy's trunk continues this one as one axis
  std::uint32_t from_order = 0;  ///< only axes of these orders bear the copy
  std::uint32_t to_order = 99;
};

/// Random variation of copies, drawn from uniform distributions about the map.
struct IfsVariation {
  double angle_deg = 0.0;    ///< rotation about a horizontal axis
  double azimuth_deg = 0.0;  ///< rotation about the trunk that bears the copy
  double scale = 0.0;        ///< relative to the scale, below 1
};

/// Limits of the recursion.
struct IfsLimits {
  int depth = 5;             ///< of copies, at most 64
  double least_scale = 0.0;  ///< a copy with a smaller trunk, relative to the first, is omitted
  std::size_t most_copies = 20000;
};

/// The trunk, of which all axes are copies.
struct IfsTrunk {
  int segments = 2;
  double radius = 0.03;      ///< at its base, relative to its length
  double tip_radius = 0.5;   ///< relative to the base's
  double crookedness = 0.0;  ///< random displacement of inner points, relative to the length
};

struct IfsLeaves {
  std::size_t count = 1000;  ///< drawn by the maps' probabilities
  double length = 0.1;       ///< relative to the first trunk's length
  double angle_deg = 50.0;   ///< from the axis that bears them
};

/// The content of a file models/ifs/NAME.json: an iterated function system, whose attractor is the
/// union of its images under the maps.
/// Source: Hutchinson 1981, Indiana University Mathematics Journal 30; Barnsley 1988, Fractals
/// Everywhere.
struct IfsPreset : FreePreset {
  std::vector<IfsCopy> copies{};
  IfsTrunk trunk{};
  IfsVariation variation{};
  IfsLimits limits{};
  IfsLeaves leaves{};
};

/// The tree of recursive copies; its trunk has length 1.
///
/// Each map places a copy on the trunk, and on each copy's trunk again. Leaves are drawn by the
/// chaos game: from the first trunk on, the maps' probabilities select a copy of the current copy,
/// down to the last one.
/// \param has_leaves  whether leaves are drawn
/// \throws GeometryError if there are more copies than the limits allow
Skeleton grow_ifs(const IfsPreset& preset, Random& random, bool has_leaves = true);

/// IFS trees, fitted to measurements.
class IfsBuilder : public FreeBuilder {
 public:
  /// \throws InputError naming file and field
  static std::unique_ptr<IfsBuilder> load(const std::filesystem::path& models,
                                          const std::filesystem::path& file);

  explicit IfsBuilder(IfsPreset preset)
      : FreeBuilder(BuilderKind::kIfs), preset_(std::move(preset)) {}

  const IfsPreset& preset() const override { return preset_; }

  Skeleton grow_freely(double h_m, Random& random) const override;

 private:
  Skeleton drawn(double h_m, bool has_leaves, Random& random) const override;
  std::string file_of(double /*h_m*/) const override { return {}; }

  IfsPreset preset_;
};

}  // namespace silvafit::tree
