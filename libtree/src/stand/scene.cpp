// SPDX-License-Identifier: MIT
#include "silvafit/tree/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fitted/standing_skeleton.hpp"
#include "silvafit/base/enum_words.hpp"
#include "silvafit/base/error.hpp"
#include "stand/dead_wood.hpp"

namespace silvafit::tree {

namespace {

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
  tree.notes.push_back({"remains", "drawn as a " + word_of(morphology.remains)});
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
