// SPDX-License-Identifier: MIT
// Writes files for other programs to read: grow_samples MODELS DIR.
//   DIR/*.glb          one file a preset of segments without textures, and one of every builder's
//   with
//                      textures, with ordinary and extreme trees; one with all presets of segments
//   DIR/scenes/*       one stand of shared models in every format and packing
//   DIR/scenes/expected.json  what a reader should find in each of them
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/ground.hpp"
#include "silvafit/tree/scene.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace {

using namespace silvafit::tree;
namespace fs = std::filesystem;

std::vector<Morphology> sample_trees() {
  std::vector<Morphology> trees;
  const auto add = [&trees](double dbh_cm, double h_m, double hcb_m, CrownRadii radii) {
    const auto number = static_cast<double>(trees.size());
    trees.push_back({.plot = "validator",
                     .tree = std::to_string(trees.size()),
                     .position = {10.0 * number, -5.0 * number, number},
                     .dbh_cm = dbh_cm,
                     .h_m = h_m,
                     .hcb_m = hcb_m,
                     .radii = radii});
  };
  add(24, 20.2, 5.8, {2.1, 2.5, 1.5, 2.4});
  add(0.1, 1.301, 0, {0.05, 0.05, 0.05, 0.05});
  add(150, 60, 0, {12, 9, 15, 11});
  add(8, 4, 3.95, {6, 1, 6, 1});
  return trees;
}

void write_glb(const std::vector<SceneTree>& trees, const fs::path& path) {
  const auto writer = open_scene(path, SceneFormat::kGlb);
  for (const SceneTree& tree : trees) writer->add_tree(tree);
  writer->finish();
}

void write_presets(const BuilderCatalogue& catalogue, const fs::path& folder) {
  std::vector<SceneTree> all;
  for (const Builder* preset : catalogue.of(BuilderKind::kSegment)) {
    std::vector<SceneTree> trees;
    for (const Morphology& tree : sample_trees()) trees.push_back(grow_tree(tree, *preset));
    write_glb(trees, folder / (preset->name() + ".glb"));
    all.push_back(std::move(trees.front()));
  }
  write_glb(all, folder / "all-presets.glb");
  // Pictures need UVs and tangents.
  const auto textured = [&](const char* preset) {
    return grow_tree(sample_trees().front(),
                     catalogue.named(BuilderKind::kSegment, preset),
                     {.mesh = {.closed_branches = true, .textured = true}});
  };
  const SceneTree tree = textured("schima-superba");
  write_glb({tree}, folder / "textured.glb");
  const auto packed =
      open_scene(folder / "textured-packed.glb", SceneFormat::kGlb, {.compress = true});
  packed->add_tree(tree);
  packed->add_tree(textured("generic-conifer"));
  packed->finish();
}

/// All presets of all builders as `silvafit grow` draws them, at every level of detail, and as
/// impostors.
void write_builders(const BuilderCatalogue& catalogue, const fs::path& folder) {
  Impostors impostors;
  const auto far = open_scene(folder / "impostors.glb", SceneFormat::kGlb);
  const auto packed =
      open_scene(folder / "impostors-packed.glb", SceneFormat::kGlb, {.compress = true});
  for (const BuilderKind kind : silvafit::all_values<BuilderKind>()) {
    for (const Builder* builder : catalogue.of(kind)) {
      std::vector<SceneTree> trees;
      int level = 0;
      for (const Morphology& tree : sample_trees()) {
        const MeshOptions mesh = level_of_detail(level, {.textured = true});
        trees.push_back(grow_tree(tree, *builder, {.mesh = mesh}));
        level = (level + 1) % kLevelsOfDetail;
        const SceneTree impostor = grow_tree(tree, *builder, {.impostors = &impostors});
        far->add_tree(impostor);
        packed->add_tree(impostor);
      }
      write_glb(trees,
                folder / (std::string(silvafit::word_of(kind)) + "-" + builder->name() + ".glb"));
    }
  }
  far->finish();
  packed->finish();
}

/// A row of twelve trees of one model, each 5 % higher and 5 % narrower north-south than the last.
class Stand {
 public:
  explicit Stand(const BuilderCatalogue& catalogue) {
    tree_ = grow_tree(sample_trees().front(),
                      catalogue.named(BuilderKind::kSegment, "cunninghamia-lanceolata"));
    for (int i = 0; i < kTrees; ++i) {
      const double size = 1.0 + 0.05 * i;
      places_.push_back({{5.0 * i, 1.5 * i, 0.5 * i}, 1.0, size, 1.0 / size});
      stems_.push_back(places_.back().position);
    }
    ground_ = ground_mesh(stems_, {});
  }

  void write(const fs::path& path, SceneFormat format, const SceneOptions& options) const {
    const auto writer = open_scene(path, format, options);
    const auto model = writer->add_model("fir", parts_of(tree_.mesh, tree_.preset));
    for (std::size_t i = 0; i < places_.size(); ++i) {
      writer->place(model, "fir-" + std::to_string(i), places_[i], i);
    }
    const auto ground = writer->add_model("ground", {{"ground", "ground", &ground_}});
    writer->place(ground, "ground", {}, SceneWriter::kNoTree);
    writer->finish();
  }

  /// From the measurements: the ground reaches 2 m beyond the stems, wider than the last crown.
  void write_expected(const fs::path& path) const {
    const double size = 1.0 + 0.05 * (kTrees - 1);
    char text[256];
    std::snprintf(text,
                  sizeof(text),
                  "{\"triangles\": %zu, \"top\": %.17g, \"east\": %.17g, \"west\": %.17g}\n",
                  kTrees * tree_.measured.triangles + ground_.triangle_count(),
                  0.5 * (kTrees - 1) + size * 20.2,
                  5.0 * (kTrees - 1) + 2.1,
                  -2.5);
    silvafit::write_file(path, text);
  }

 private:
  static constexpr int kTrees = 12;
  SceneTree tree_;
  std::vector<Placement> places_;
  std::vector<Position> stems_;
  MeshPart ground_;
};

void write_scenes(const BuilderCatalogue& catalogue, const fs::path& folder) {
  const Stand stand(catalogue);
  stand.write(folder / "plain.glb", SceneFormat::kGlb, {});
  stand.write(folder / "plain.gltf", SceneFormat::kGltf, {});
  stand.write(folder / "quantized.glb", SceneFormat::kGlb, {.quantize = true});
  stand.write(folder / "packed.glb", SceneFormat::kGlb, {.compress = true});
  stand.write(folder / "instanced.glb", SceneFormat::kGlb, {.instancing = true});
  stand.write(
      folder / "instanced-packed.glb", SceneFormat::kGlb, {.instancing = true, .compress = true});
  stand.write(
      folder / "instanced-packed.gltf", SceneFormat::kGltf, {.instancing = true, .compress = true});
  stand.write(folder / "scene.obj", SceneFormat::kObj, {});
  stand.write(folder / "scene.ply", SceneFormat::kPly, {});
  stand.write(folder / "text.ply", SceneFormat::kPly, {.ascii = true});
  stand.write_expected(folder / "expected.json");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 3) throw std::invalid_argument("usage: grow_samples MODELS DIR");
    const BuilderCatalogue catalogue = BuilderCatalogue::load(argv[1]);
    const fs::path folder = argv[2];
    write_presets(catalogue, folder);
    write_builders(catalogue, folder);
    write_scenes(catalogue, folder / "scenes");
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
