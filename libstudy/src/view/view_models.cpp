// SPDX-License-Identifier: MIT
#include "view/view_models.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/tree/ground.hpp"
#include "silvafit/tree/scene.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::study {
namespace {

/// All models at all levels, model by model.
std::vector<tree::SceneTree> grown_models(const tree::SharedModels& shared,
                                          const ViewOptions& options) {
  const std::size_t levels = options.levels.size();
  std::vector<tree::SceneTree> grown(shared.models.size() * levels);
  parallel_for(grown.size(), options.threads, [&](std::size_t i) {
    const tree::SharedModel& model = shared.models[i / levels];
    const tree::GrowOptions grow{
        .seed = options.seed,
        .mesh = tree::level_of_detail(options.levels[i % levels],
                                      {.textured = options.textures, .season = options.season})};
    grown[i] = tree::grow_tree(model.morphology, *model.builder, grow);
  });
  return grown;
}

std::string packed(const tree::SharedModels& shared,
                   std::span<const tree::Position> stems,
                   const tree::Position& origin,
                   const ViewOptions& options) {
  // The scene is written to a temporary file.
  const TemporaryFolder folder("silvafit-view");
  const std::filesystem::path path = folder.path() / "models.glb";
  const auto writer =
      tree::open_scene(path, tree::SceneFormat::kGlb, {.origin = origin, .compress = true});
  const std::vector<tree::SceneTree> grown = grown_models(shared, options);
  for (std::size_t i = 0; i < grown.size(); ++i) {
    const std::size_t model = i / options.levels.size();
    const std::string name =
        fmt::format("model-{}-level-{}", model, options.levels[i % options.levels.size()]);
    const auto added = writer->add_model(
        name, tree::parts_of(grown[i].mesh, shared.models[model].builder->name()));
    writer->place(added, name, {.position = origin}, tree::SceneWriter::kNoTree);
  }
  const tree::MeshPart ground = tree::ground_mesh(stems, origin, 4.0, options.terrain.get());
  const auto added = writer->add_model("ground", {{"ground", "ground", &ground}});
  writer->place(added, "ground", {.position = origin}, tree::SceneWriter::kNoTree);
  writer->finish();
  return read_file(path);
}

}  // namespace

ViewModels grow_view_models(std::span<const tree::Morphology> trees,
                            std::span<const tree::Builder* const> presets,
                            std::span<const tree::Position> stems,
                            const tree::Position& origin,
                            const ViewOptions& options) {
  ViewModels result{.shared = tree::share_models(trees, presets, options.models_per_preset)};
  result.glb = packed(result.shared, stems, origin, options);
  return result;
}

}  // namespace silvafit::study
