// SPDX-License-Identifier: MIT
// Trees from iterated function systems: a few maps that make a tree of smaller copies of itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "silvafit/tree/affine_map.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// An iterated function system (IFS): maps that shrink space, each with its probability.
///
/// Its attractor is the one compact set that is the union of its images under the maps; its
/// invariant measure mu = sum p_i mu(M_i^-1) is the one that the chaos game draws from.
/// Source: Hutchinson 1981, Indiana University Mathematics Journal 30; Barnsley 1988, Fractals
/// Everywhere.
class IteratedFunctionSystem {
 public:
  /// \param probabilities  one each, > 0, adding up to 1 within 1e-9; or none, for probabilities in
  ///                       proportion to |det A|, a flat map's taken as a thousandth
  /// \throws DomainError if there is no map, one does not shrink space (spectral norm < 1), or the
  ///                     probabilities are none
  explicit IteratedFunctionSystem(std::vector<AffineMap> maps,
                                  std::vector<double> probabilities = {});

  const std::vector<AffineMap>& maps() const { return maps_; }
  const std::vector<double>& probabilities() const { return probabilities_; }

  /// Points of the attractor by the chaos game: a point jumps from image to image under maps drawn
  /// by their probabilities. Distributed by the invariant measure, but for what is left of the
  /// start, which lies on the attractor, after 64 jumps.
  std::vector<Point> chaos_game(std::size_t count, Random& random) const;

  /// The solution D of sum s_i^D = 1 for the maps' scales s_i = |det A|^(1/3) (Moran 1946): the
  /// attractor's dimension if the maps are similarities whose images do not overlap.
  double similarity_dimension() const;

 private:
  /// Index of the map that a number drawn from [0, 1) chooses.
  std::size_t drawn(double uniform) const;

  std::vector<AffineMap> maps_;
  std::vector<double> probabilities_;
  std::vector<double> cumulative_;
};

/// A map that puts a smaller copy of the whole tree on its trunk.
///
/// The trunk is the line from the origin to (0, 0, 1). Given by its place: the copy stands on the
/// trunk at a share of its length, leans by an angle towards an azimuth and is turned about its own
/// trunk; or by a matrix.
struct IfsCopy {
  AffineMap map{};
  double scale = 0.5;            ///< of the copy's trunk
  double thickness = 0.5;        ///< radius of the copy's trunk as a share of the trunk's
  bool continues = false;        ///< the copy's trunk goes on with this one as one axis
  std::uint32_t from_order = 0;  ///< only axes of these orders bear the copy
  std::uint32_t to_order = 99;
};

/// How much copies differ, each drawn from a uniform distribution about the map.
struct IfsVariation {
  double angle_deg = 0.0;    ///< turn about a level axis
  double azimuth_deg = 0.0;  ///< turn about the trunk that bears the copy
  double scale = 0.0;        ///< as a share of the scale, below 1
};

/// When copies of copies end.
struct IfsLimits {
  int depth = 5;  ///< of copies, at most 64
  double least_scale =
      0.0;  ///< a copy with a smaller trunk than this share of the first is left out
  std::size_t most_copies = 20000;
};

/// The trunk, from which all axes are copied.
struct IfsTrunk {
  int segments = 2;
  double radius = 0.03;      ///< at its base, as a share of its length
  double tip_radius = 0.5;   ///< as a share of the base's
  double crookedness = 0.0;  ///< how far inner points stray at random, as a share of the length
};

struct IfsLeaves {
  std::size_t count = 1000;  ///< drawn by the maps' probabilities
  double length = 0.1;       ///< as a share of the first trunk's length
  double angle_deg = 50.0;   ///< from the axis that bears them
};

/// What a file models/ifs/NAME.json says.
struct IfsPreset {
  IteratedFunctionSystem system;
  std::vector<IfsCopy> copies{};  ///< in the order of the system's maps
  IfsTrunk trunk{};
  IfsVariation variation{};
  IfsLimits limits{};
  IfsLeaves leaves{};
  SmoothStyle style{};
};

/// The tree of copies of copies, its trunk one long.
///
/// Each map puts a copy on the trunk, and on each copy's trunk again. Leaves are drawn by the chaos
/// game: from the first trunk on the maps' probabilities choose a copy of the copy before, to the
/// last that there is.
/// \throws GeometryError if there are more copies than the limits allow
Skeleton grow_ifs(const IfsPreset& preset, Random& random);

/// Trees of copies of themselves, fitted to measurements.
class IfsBuilder : public Builder {
 public:
  /// \throws InputError naming file and field
  static std::unique_ptr<IfsBuilder> load(const std::filesystem::path& models,
                                          const std::filesystem::path& file);

  IfsBuilder(PresetHead head, IfsPreset preset);

  const IfsPreset& ifs() const { return ifs_; }

  Skeleton grow_skeleton(const TreeShape& shape, const Crown& crown, Random& random) const override;
  Mesh build_mesh(const Skeleton& skeleton,
                  const Crown& crown,
                  Random& random,
                  const MeshOptions& options) const override;

 private:
  IfsPreset ifs_;
};

}  // namespace silvafit::tree
