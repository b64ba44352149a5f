// SPDX-License-Identifier: MIT
#include "silvafit/tree/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fitted/standing_skeleton.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {
namespace {

/// Height of a stump [m]: one foot, above which FIA counts volumes of stems.
constexpr double kStumpHeight = 0.3;

/// Of a snag; 1 if it was not recorded.
std::size_t decay_class_of(const Morphology& morphology) {
  return static_cast<std::size_t>(morphology.decay_class.value_or(1.0));
}

/// A stem up to a height, where its section is closed by a cone.
std::vector<SkeletonPoint> lower_part(std::span<const SkeletonPoint> stem,
                                      double top_m,
                                      double cone_m) {
  const SkeletonPoint end = at_height(stem, top_m - cone_m);
  std::vector<SkeletonPoint> part;
  for (const SkeletonPoint& point : stem) {
    if (point.at.z < end.at.z) part.push_back(point);
  }
  part.push_back(end);
  part.push_back({{end.at.x, end.at.y, top_m}, 0.0});
  return part;
}

std::vector<SkeletonPoint> remaining_stem(const Morphology& morphology,
                                          std::span<const SkeletonPoint> stem) {
  // A saw leaves a flat face; rings closer than 2 mm to the tip are not drawn.
  constexpr double kSawn = 0.002;
  if (morphology.remains == Remains::kStump) return lower_part(stem, kStumpHeight, kSawn);
  if (morphology.remains == Remains::kLog) {
    // Bends of the crown would lift the log off the ground.
    std::vector<SkeletonPoint> straight(stem.begin(), stem.end());
    for (SkeletonPoint& point : straight) point.at = {0.0, 0.0, point.at.z};
    return straight;
  }
  if (decay_class_of(morphology) == 1) return {stem.begin(), stem.end()};
  // Splinters as long as the stem is thick, above the section whose diameter is measured.
  const double splinters = std::min(2.0 * at_height(stem, morphology.h_m).radius_m,
                                    0.5 * (morphology.h_m - kBreastHeight));
  return lower_part(stem, morphology.h_m, splinters);
}

/// The points of a branch of a snag that are left; none if the branch is gone.
std::span<const SkeletonPoint> remaining_branch(const Axis& axis,
                                                std::size_t number,
                                                std::size_t decay_class,
                                                std::span<const SkeletonPoint> line) {
  if (decay_class == 1) return line;
  if (axis.order > 1 || decay_class > 3) return {};
  constexpr std::size_t kFew = 3;  // of class 2: one branch of this number
  if (decay_class == 2 && number % kFew != 0) return {};
  return line;
}

/// Makes the shape of a snag with a broken top that of the tree before it broke, of which the
/// measured height is the lower part. Notes tell what was assumed.
void stand_before_breaking(const Morphology& morphology, TreeShape& shape) {
  if (morphology.remains != Remains::kSnag) return;
  if (!morphology.decay_class) {
    shape.notes.push_back({"decay", "decay class not recorded: drawn with all branches (class 1)"});
  }
  // FIA's classes tell that a top is broken, not how much is gone: less of older snags is left.
  constexpr std::array<double, 5> kLeft{1.0, 0.9, 0.7, 0.5, 0.4};
  const double left = kLeft[decay_class_of(morphology) - 1];
  if (left == 1.0) return;
  shape.h_m /= left;
  shape.notes.push_back(
      {"broken_top",
       fmt::format("height before the top broke not known: the snag is drawn as the lower {} of it",
                   left)});
}

/// The wood that is left of a grown tree: its stem up to the measured height of a snag, up to
/// kStumpHeight, or all of a log; and the branches of a snag by its decay class.
///
/// Decay classes of standing dead trees of FIA, as in Domke, Woodall, Smith 2011 (Carbon Balance
/// and Management 6:14, table 1): 1, all branches, pointed top; 2, few branches and no fine ones,
/// broken top; 3, stubs; 4 and 5, none.
Skeleton remains_of(const Morphology& morphology, const Skeleton& skeleton) {
  Skeleton left;
  left.add_axis(0, 0, remaining_stem(morphology, skeleton.points_of(skeleton.axes.front())));
  if (morphology.remains != Remains::kSnag) return left;
  const std::size_t decay_class = decay_class_of(morphology);
  std::vector<std::uint32_t> number(skeleton.axes.size(), kNone);
  number.front() = 0;
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) {
    const Axis& axis = skeleton.axes[i];
    if (number[axis.parent] == kNone) continue;
    const auto line = remaining_branch(axis, i, decay_class, skeleton.points_of(axis));
    const auto is_above = [&](const SkeletonPoint& point) {
      return point.at.z + point.radius_m > morphology.h_m;
    };
    // A whole top's branches are inside the crown, whose height is the measured one.
    const bool is_broken_off = decay_class > 1 && std::ranges::any_of(line, is_above);
    if (line.empty() || is_broken_off) continue;
    if (decay_class < 3) {
      number[i] = left.add_axis(axis.order, number[axis.parent], line);
      continue;
    }
    constexpr double kStub_m = 0.25;  // from the bark
    const double stem_radius =
        at_height(skeleton.points_of(skeleton.axes.front()), line.front().at.z).radius_m;
    const double share = (stem_radius + kStub_m) / line_length_m(line);
    if (share >= 1.0) continue;
    left.add_axis(1, 0);
    left.add_point(line.front().at, line.front().radius_m);
    left.add_point(point_at(line, share).at, 0.0);
  }
  return left;
}

/// Turns a standing stem on its base to the ground, towards a random azimuth.
void lay_down(Mesh& mesh, Random& random) {
  const double azimuth = random.uniform(0.0, kTwoPi);
  const float east = static_cast<float>(std::cos(azimuth));
  const float south = static_cast<float>(std::sin(azimuth));
  // Up becomes the direction of the fall, and that direction down.
  const auto turn = [east, south](std::vector<float>& vectors, std::size_t size) {
    for (std::size_t i = 0; i + 2 < vectors.size(); i += size) {
      const float along = vectors[i] * east + vectors[i + 2] * south;
      const float across = vectors[i + 2] * east - vectors[i] * south;
      const float up = vectors[i + 1];
      vectors[i] = up * east - across * south;
      vectors[i + 1] = -along;
      vectors[i + 2] = up * south + across * east;
    }
  };
  float lowest = 0.0F;
  for (MeshPart& part : mesh.parts) {
    turn(part.positions, 3);
    turn(part.normals, 3);
    turn(part.tangents, 4);
    for (std::size_t i = 1; i < part.positions.size(); i += 3) {
      lowest = std::min(lowest, part.positions[i]);
    }
  }
  for (MeshPart& part : mesh.parts) {
    for (std::size_t i = 1; i < part.positions.size(); i += 3) part.positions[i] -= lowest;
  }
}

/// Runs a step of one tree's growth; errors get the tree's name.
template <typename Stage>
auto named(const Morphology& morphology, Stage stage) {
  try {
    return stage();
  } catch (const GeometryError& error) {
    throw GeometryError(
        error.message(),
        {.file = error.place().file, .plot = morphology.plot, .tree = morphology.tree});
  } catch (const NumericalError& error) {
    throw GeometryError(
        error.message(),
        {.plot = morphology.plot, .tree = morphology.tree, .model = error.place().model});
  }
}

/// A tree up to its skeleton.
struct Grown {
  TreeShape shape;
  Crown crown;
  Random random;
  Skeleton skeleton;
};

/// The tree as it is drawn, scaled to its height.
Grown grow_freely(const Morphology& morphology,
                  const Builder& builder,
                  const GrowOptions& options) {
  validate_height(morphology);
  Random random = random_of_tree(options.seed, morphology.plot, morphology.tree);
  Skeleton skeleton = scaled_to_height(builder.grow_freely(morphology.h_m, random), morphology.h_m);
  TreeShape shape = shape_of(skeleton);
  Crown crown = Crown::unbounded(shape);
  return {std::move(shape), std::move(crown), random, std::move(skeleton)};
}

Grown grow_to_skeleton(const Morphology& morphology,
                       const Builder& builder,
                       const GrowOptions& options) {
  if (options.is_unfitted) return grow_freely(morphology, builder, options);
  TreeShape shape = builder.shape_of(morphology);
  stand_before_breaking(morphology, shape);
  Crown crown(shape, builder.preset().crown_index);
  Random random = random_of_tree(options.seed, morphology.plot, morphology.tree);
  Skeleton skeleton = builder.grow_skeleton(shape, crown, random, options.mesh);
  return {std::move(shape), std::move(crown), random, std::move(skeleton)};
}

SceneTree tree_of(const Morphology& morphology, const Builder& builder) {
  return {.plot = morphology.plot,
          .tree = morphology.tree,
          .species = morphology.species,
          .preset = builder.name(),
          .position = morphology.position};
}

SceneTree grow_impostor(const Morphology& morphology,
                        const Builder& builder,
                        const GrowOptions& options) {
  SceneTree tree = tree_of(morphology, builder);
  TreeShape shape = builder.shape_of(morphology);
  Random random = random_of_tree(options.seed, morphology.plot, morphology.tree);
  tree.mesh = options.impostors->build(builder, shape, random, options.mesh);
  tree.measured = measure(tree.mesh);
  tree.notes = std::move(shape.notes);
  return tree;
}

SceneTree grow_dead_wood(const Morphology& morphology,
                         const Builder& builder,
                         const GrowOptions& options) {
  Grown grown = grow_to_skeleton(morphology, builder, options);
  SceneTree tree = tree_of(morphology, builder);
  if (morphology.remains == Remains::kSnag) tree.notes = std::move(grown.shape.notes);
  const Skeleton remains = remains_of(morphology, grown.skeleton);
  tree.mesh = builder.build_mesh(remains, grown.crown, grown.random, options.mesh);
  std::erase_if(tree.mesh.parts, [](const MeshPart& part) {
    return part.kind != PartKind::kStem && part.kind != PartKind::kBranches;
  });
  tree.measured = measure_dead_wood(tree.mesh);
  if (morphology.remains == Remains::kLog) lay_down(tree.mesh, grown.random);
  return tree;
}

std::string crossing_note(std::size_t crossing) {
  return fmt::format(
      "{} branches at measured radii cross a neighbor's stem or branch, because the stems are too "
      "close to each other",
      crossing);
}

}  // namespace

SceneTree grow_tree(const Morphology& morphology,
                    const Builder& builder,
                    const GrowOptions& options,
                    const TreeOverlap* overlap) {
  if (options.impostors != nullptr && (overlap != nullptr || options.is_unfitted)) {
    throw UsageError("impostors show whole, fitted crowns; they need trees without overlaps");
  }
  const bool is_dead = morphology.remains != Remains::kAll;
  if (is_dead && (overlap != nullptr || options.is_unfitted)) {
    throw UsageError("dead wood has no crown; it needs trees without overlaps, and fitted ones");
  }
  return named(morphology, [&] {
    if (is_dead) return grow_dead_wood(morphology, builder, options);
    if (options.impostors != nullptr) return grow_impostor(morphology, builder, options);
    Grown grown = grow_to_skeleton(morphology, builder, options);
    SceneTree tree = tree_of(morphology, builder);
    tree.notes = grown.shape.notes;
    if (overlap != nullptr) {
      PrunedSkeleton pruned = prune(grown.skeleton, grown.crown, *overlap);
      tree.removed_share = pruned.removed_share();
      grown.skeleton = std::move(pruned.skeleton);
    }
    tree.mesh = builder.build_mesh(grown.skeleton, grown.crown, grown.random, options.mesh);
    if (overlap != nullptr) keep_within(overlap->territory, tree.mesh);
    tree.measured = measure(tree.mesh);
    const std::vector<Note>& notes = grown.skeleton.notes;
    tree.notes.insert(tree.notes.end(), notes.begin(), notes.end());
    if (overlap != nullptr && overlap->crossing > 0) {
      tree.notes.push_back({"overlap", crossing_note(overlap->crossing)});
    }
    return tree;
  });
}

StandTree grow_for_stand(const Morphology& morphology,
                         const Builder& builder,
                         const GrowOptions& options) {
  return named(morphology, [&] {
    const Grown grown = grow_to_skeleton(morphology, builder, options);
    return stand_tree(morphology, grown.crown, grown.skeleton);
  });
}

Position scene_origin(const std::vector<Morphology>& morphologies) {
  // A float resolves 1 mm up to 2^13 m and slightly beyond.
  constexpr double kFar = 8192.0;
  constexpr double kRound = 100.0;
  if (morphologies.empty()) return {};
  const auto origin_of = [&](double Position::*axis) {
    double least = std::numeric_limits<double>::infinity();
    double farthest = 0.0;
    for (const Morphology& morphology : morphologies) {
      least = std::min(least, morphology.position.*axis);
      farthest = std::max(farthest, std::abs(morphology.position.*axis));
    }
    return farthest > kFar ? kRound * std::floor(least / kRound) : 0.0;
  };
  return {origin_of(&Position::x_m), origin_of(&Position::y_m), origin_of(&Position::z_m)};
}

}  // namespace silvafit::tree
