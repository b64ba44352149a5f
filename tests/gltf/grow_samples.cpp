// SPDX-License-Identifier: MIT
// Writes GLB files for the validator: grow_samples MODELS DIR. One file a preset, with ordinary and
// extreme trees, and one scene with all presets.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "silvafit/tree/scene.hpp"

namespace {

using namespace silvafit::tree;

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

void write_samples(const std::filesystem::path& models, const std::filesystem::path& folder) {
  const PresetCatalogue catalogue = PresetCatalogue::load(models);
  Scene all;
  for (const Preset& preset : catalogue.presets()) {
    Scene scene;
    for (const Morphology& tree : sample_trees()) scene.trees.push_back(grow_tree(tree, preset));
    write_glb(scene, folder / (preset.name + ".glb"));
    all.trees.push_back(std::move(scene.trees.front()));
  }
  write_glb(all, folder / "all-presets.glb");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 3) throw std::invalid_argument("usage: grow_samples MODELS DIR");
    write_samples(argv[1], argv[2]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
