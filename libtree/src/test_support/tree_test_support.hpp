// SPDX-License-Identifier: MIT
// Common data of the tests of this library: the catalogue, trees of the paper, random trees.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "reference.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/tree/scene.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::test {

inline const tree::BuilderCatalogue& shipped_builders() {
  static const tree::BuilderCatalogue catalogue =
      tree::BuilderCatalogue::load(source_file("models"));
  return catalogue;
}

/// The shipped presets of the builder segment, by name.
class ShippedPresets {
 public:
  ShippedPresets() {
    for (const tree::Builder* builder : shipped_builders().of(tree::BuilderKind::kSegment)) {
      presets_.push_back(dynamic_cast<const tree::SegmentBuilder&>(*builder).preset());
    }
  }

  const std::vector<tree::Preset>& presets() const { return presets_; }
  const tree::Preset& named(std::string_view name) const {
    const tree::Builder& builder = shipped_builders().named(tree::BuilderKind::kSegment, name);
    return dynamic_cast<const tree::SegmentBuilder&>(builder).preset();
  }

 private:
  std::vector<tree::Preset> presets_{};
};

inline const ShippedPresets& shipped_presets() {
  static const ShippedPresets presets;
  return presets;
}

/// Shoots with a picture of those that ship.
inline tree::LeafyShoots shoots_of(double length_m, double leaf_area_index) {
  return {.picture = shipped_presets().named("schima-superba").leafy_shoots.picture,
          .length_m = length_m,
          .leaf_area_index = leaf_area_index};
}

/// The path of an error in a file of the catalogue; for a missing or unknown key, that of the key.
inline std::string path_of(const InputError& error) {
  constexpr std::string_view kMark = "key \"";
  const std::string& path = error.place().column;
  const std::size_t at = error.message().find(kMark);
  if (at == std::string::npos) return path;
  const std::string key = error.message().substr(at + kMark.size());
  return (path.empty() ? "" : path + ".") + key.substr(0, key.find('"'));
}

/// Tree 1 of the Chinese fir plot in the segment-model paper (its Table II).
inline tree::Morphology paper_tree_1() {
  return {.plot = "1",
          .tree = "1",
          .species = "Cunninghamia lanceolata",
          .dbh_cm = 28.1,
          .h_m = 20.2,
          .hcb_m = 5.8,
          .hc_m = 8.8,
          .radii = tree::CrownRadii{2.1, 2.5, 1.5, 2.4}};
}

/// Random trees that pass validate(), with many extreme ones: just above breast height, crowns that
/// start at the ground or right below the tip, crowns wider than the tree is high, very thin and
/// very thick stems.
inline tree::Morphology random_morphology(Random& random, int number) {
  tree::Morphology tree{.plot = "p", .tree = std::to_string(number)};
  const auto one_in = [&random](int n) { return random.below(static_cast<std::uint64_t>(n)) == 0; };
  tree.h_m = one_in(4) ? 1.3 + random.uniform(1e-6, 0.5) : random.uniform(1.5, 50.0);
  tree.hcb_m = one_in(4) ? 0.0 : tree.h_m * random.uniform(0.0, 0.95);
  if (one_in(6)) tree.hcb_m = tree.h_m - random.uniform(0.01, 0.1);
  tree.dbh_cm = one_in(4) ? random.uniform(0.1, 1.0) : random.uniform(1.0, 150.0);
  const auto radius = [&] {
    return one_in(3) ? random.uniform(0.05, 0.3) : random.uniform(0.3, 9.0);
  };
  if (one_in(2)) {
    tree.radii = tree::CrownRadii{radius(), radius(), radius(), radius()};
  } else {
    tree.cw_m = 2.0 * radius();
  }
  if (one_in(2)) tree.hc_m = tree.hcb_m + random.uniform(0.0, 1.0) * (tree.h_m - tree.hcb_m);
  if (one_in(8)) tree.hc_m = one_in(2) ? tree.hcb_m : tree.h_m;
  if (one_in(3)) tree.age_years = random.uniform(1.0, 60.0);
  return tree;
}

/// The stages before the mesh, for one tree.
struct Stages {
  tree::TreeShape shape;
  tree::Crown crown;
  tree::Skeleton skeleton;
};

inline Stages stages_of(const tree::Morphology& morphology,
                        const tree::Preset& preset,
                        std::uint64_t seed = 1) {
  tree::TreeShape shape = tree::complete(morphology, preset.relative_hc, preset.name);
  tree::Crown crown(shape, preset.crown_index);
  Random random = tree::random_of_tree(seed, morphology.plot, morphology.tree);
  tree::Skeleton skeleton = tree::SegmentBuilder(preset).grow_skeleton(shape, crown, random);
  return {std::move(shape), std::move(crown), std::move(skeleton)};
}

/// Trees in one file, of which every tree has its own mesh.
struct Scene {
  tree::Position origin{};
  std::vector<tree::SceneTree> trees{};
};

inline void write_glb(const Scene& scene, const std::filesystem::path& path) {
  const auto writer = tree::open_scene(path, tree::SceneFormat::kGlb, {.origin = scene.origin});
  for (const tree::SceneTree& tree : scene.trees) writer->add_tree(tree);
  writer->finish();
}

inline std::string glb_bytes(const Scene& scene) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / fmt::format("silvafit-scene-{}.glb", getpid());
  write_glb(scene, path);
  const std::string bytes = read_file(path);
  std::filesystem::remove(path);
  return bytes;
}

}  // namespace silvafit::test

namespace silvafit::tree {

/// With the builder segment.
inline SceneTree grow_tree(const Morphology& morphology,
                           const Preset& preset,
                           const GrowOptions& options = {},
                           const TreeOverlap* overlap = nullptr) {
  return grow_tree(morphology, SegmentBuilder(preset), options, overlap);
}

}  // namespace silvafit::tree
