// SPDX-License-Identifier: MIT
#include "silvafit/tree/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {

SceneTree grow_tree(const Morphology& morphology,
                    const Preset& preset,
                    const GrowOptions& options) {
  try {
    const TreeShape shape = complete(morphology, preset.relative_hc, "preset " + preset.name);
    const Crown crown(shape, preset.crown_index);
    Random random = random_of_tree(options.seed, morphology.plot, morphology.tree);
    Skeleton skeleton = grow_skeleton(shape, crown, preset, random);
    SceneTree tree{.plot = morphology.plot,
                   .tree = morphology.tree,
                   .species = morphology.species,
                   .preset = preset.name,
                   .position = morphology.position,
                   .mesh = build_mesh(skeleton, crown, preset, random, options.mesh),
                   .notes = shape.notes};
    tree.measured = measure(tree.mesh);
    tree.notes.insert(tree.notes.end(), skeleton.notes.begin(), skeleton.notes.end());
    return tree;
  } catch (const GeometryError& error) {
    throw GeometryError(error.message(), {.plot = morphology.plot, .tree = morphology.tree});
  } catch (const NumericalError& error) {
    throw GeometryError(
        error.message(),
        {.plot = morphology.plot, .tree = morphology.tree, .model = error.place().model});
  }
}

Position scene_origin(const std::vector<Morphology>& morphologies) {
  // A float resolves 1 mm up to 2^13 m and a little beyond.
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
