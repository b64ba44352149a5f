// SPDX-License-Identifier: MIT
// Common parts of all scenes: the trees' builders, options of the file, the ground.
#include <algorithm>

#include "silvafit/tree/ground.hpp"
#include "workflow/grow_job.hpp"

namespace silvafit::study {
std::vector<tree::PresetChoice> choose_builders(const std::vector<tree::Morphology>& morphologies,
                                                const tree::BuilderCatalogue& catalogue,
                                                const GrowJob& job,
                                                const tree::Builder* for_all) {
  if (for_all == nullptr && !job.preset.empty()) {
    for_all = &catalogue.named(job.builder, job.preset);
  }
  if (for_all != nullptr) return std::vector(morphologies.size(), tree::PresetChoice{for_all});
  std::vector<tree::PresetChoice> choices;
  for (const tree::Morphology& morphology : morphologies) {
    choices.push_back(catalogue.choose(job.builder, morphology.species));
    job.state->species.add(morphology.species, choices.back());
  }
  return choices;
}

void finish_scene(tree::SceneWriter& writer, WrittenScene& written) {
  written.bytes = writer.finish();
  for (const auto& path : writer.other_files()) written.beside.push_back(path.string());
}

tree::SceneOptions scene_options(const GrowJob& job, const tree::Position& origin) {
  return {.origin = origin,
          .instancing = job.instancing,
          .quantize = job.quantize,
          .compress = job.compress,
          .ascii = job.ascii,
          .threads = job.threads};
}

void add_ground(const GrowJob& job,
                const std::vector<tree::Morphology>& trees,
                const tree::Position& origin,
                tree::SceneWriter& writer) {
  if (job.ground == SceneGround::kNone) return;
  std::vector<tree::Position> stems;
  stems.reserve(trees.size());
  double lowest = trees.front().position.z_m;
  for (const tree::Morphology& tree : trees) {
    stems.push_back(tree.position);
    lowest = std::min(lowest, tree.position.z_m);
  }
  if (job.ground == SceneGround::kFlat) {
    // Four corners define it.
    for (tree::Position& stem : stems) stem.z_m = lowest;
    const auto by = [&](double tree::Position::*axis) {
      return std::minmax_element(stems.begin(), stems.end(), [axis](const auto& a, const auto& b) {
        return a.*axis < b.*axis;
      });
    };
    const auto [west, east] = by(&tree::Position::x_m);
    const auto [south, north] = by(&tree::Position::y_m);
    stems = {{west->x_m, south->y_m, lowest}, {east->x_m, north->y_m, lowest}};
  }
  const tree::MeshPart mesh = tree::ground_mesh(stems, origin);
  const auto model = writer.add_model("ground", {{"ground", "ground", &mesh}});
  writer.place(model, "ground", {.position = origin}, tree::SceneWriter::kNoTree);
}

}  // namespace silvafit::study
