// SPDX-License-Identifier: MIT
// Growing and writing the trees of one time, and what all scenes have in common: the trees'
// builders, options of the file, the ground.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <functional>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/tree/ground.hpp"
#include "silvafit/tree/overlap.hpp"
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
    choices.push_back(catalogue.choose(job.builder, morphology.species, job.state->reads_codes));
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
  const data::Raster* const terrain =
      job.ground == SceneGround::kStems ? job.reading.terrain.get() : nullptr;
  const tree::MeshPart mesh = tree::ground_mesh(stems, origin, 2.0, terrain);
  const auto model = writer.add_model("ground", {{"ground", "ground", &mesh}});
  writer.place(model, "ground", {.position = origin}, tree::SceneWriter::kNoTree);
}

namespace {

namespace fs = std::filesystem;

/// Grows the trees of a table and writes them.
class Grower {
 public:
  /// \param stand    all trees that share the ground and the origin
  /// \param for_all  as choose_builders()
  Grower(const GrowJob& job,
         const std::vector<tree::Morphology>& morphologies,
         const std::vector<tree::Morphology>& stand,
         const tree::BuilderCatalogue& catalogue,
         const tree::Builder* for_all)
      : job_(job),
        morphologies_(morphologies),
        stand_(stand),
        choices_(choose_builders(morphologies, catalogue, job, for_all)) {
    for (const tree::PresetChoice& choice : choices_) builders_.push_back(choice.builder);
  }

  GrowResult run() {
    for (const tree::Builder* const builder : builders_) {
      result_.presets.push_back(builder->name());
    }
    if (job_.resolve_overlaps) resolve();
    if (job_.share) {
      share();
    } else {
      for (const int level : job_.levels) {
        if (job_.scene.empty()) {
          write_alone(level);
        } else {
          write_scene(level);
        }
      }
    }
    result_.pairs = std::move(overlap_.pairs);
    return std::move(result_);
  }

 private:
  unsigned threads() const { return job_.threads; }

  void resolve() {
    tree::check_crown_density(morphologies_, threads());
    std::vector<tree::StandTree> trees(morphologies_.size());
    std::atomic<std::size_t> done = 0;
    parallel_for(trees.size(), threads(), [&](std::size_t i) {
      trees[i] = tree::grow_for_stand(morphologies_[i], *builders_[i], grow_options(job_, 0));
      job_.show("searching neighbors", ++done, trees.size());
    });
    overlap_ = tree::resolve_overlaps(trees, threads());
    for (std::size_t i = 0; i < trees.size(); ++i) {
      if (overlap_.trees[i].crossing > 0) result_.crossing.push_back(i);
    }
  }

  GrownTree grow(std::size_t i, int level) const {
    const tree::TreeOverlap* overlap = job_.resolve_overlaps ? &overlap_.trees[i] : nullptr;
    GrownTree grown{.tree = tree::grow_tree(
                        morphologies_[i], *builders_[i], grow_options(job_, level), overlap),
                    .level = level};
    constexpr double kPerMeter = 100.0;
    grown.surface_error_cm = kPerMeter * grown.tree.mesh.surface_error_m;
    if (!choices_[i].is_listed) {
      grown.tree.notes.push_back(
          {"preset", "no preset lists the species: " + builders_[i]->name()});
    }
    return grown;
  }

  /// Counts a written tree; its mesh is not kept.
  void take(std::size_t i, GrownTree grown, WrittenScene& written) {
    written.triangles += grown.tree.measured.triangles;
    if (job_.scene.empty()) written.bytes += grown.bytes;
    if (grown.level == job_.levels.front()) {
      std::set<std::string> guesses;
      for (const tree::Note& note : grown.tree.notes) guesses.insert(note.about);
      guesses.erase("overlap");
      guesses.erase("remains");
      for (const std::string& name : guesses) ++result_.counts.guesses[name];
      if (!guesses.empty()) result_.with_guesses.push_back(i);
    }
    grown.tree.mesh = {};
    if (job_.state->each_tree) job_.state->each_tree(job_.first_tree + i, grown);
    if (job_.keeps_trees) result_.trees.push_back(std::move(grown));
  }

  /// Grows a few trees at a time on all threads and passes them on in order, so that memory does
  /// not grow with their number.
  template <typename Each>
  void in_blocks(const char* stage, WrittenScene& written, Each each) {
    constexpr std::size_t kBlock = 64;
    const std::size_t count = written.trees;
    std::vector<GrownTree> block;
    for (std::size_t from = 0; from < count; from += kBlock) {
      block.assign(std::min(kBlock, count - from), {});
      parallel_for(block.size(), threads(), [&](std::size_t k) { block[k] = each(from + k); });
      for (std::size_t k = 0; k < block.size(); ++k) hand_over_(from + k, block[k]);
      for (std::size_t k = 0; k < block.size(); ++k) {
        take(from + k, std::move(block[k]), written);
      }
      job_.show(stage, from + block.size(), count);
    }
  }

  void write_alone(int level) {
    if (names_.empty()) names_ = tree_names(job_, morphologies_);
    hand_over_ = [](std::size_t, GrownTree&) {};
    WrittenScene written{.name = folder_text(job_, level), .trees = morphologies_.size()};
    in_blocks("growing", written, [&](std::size_t i) {
      GrownTree grown = grow(i, level);
      const fs::path path = tree_path(job_, names_[i], level);
      grown.file = path.string();
      tree::SceneOptions scene = scene_options(job_, {});
      scene.threads = 1;  // the files are written on all of them
      scene.pictures = &job_.state->pictures;
      const auto writer = tree::open_scene(path, job_.scene_format, scene);
      // A single tree is at the origin.
      tree::SceneTree& alone = grown.tree;
      const tree::Position place = std::exchange(alone.position, {});
      writer->add_tree(alone);
      alone.position = place;
      grown.bytes = writer->finish();
      return grown;
    });
    result_.files.push_back(std::move(written));
  }

  void write_scene(int level) {
    const fs::path path = scene_path(job_, level);
    const tree::Position origin = tree::scene_origin(stand_);
    const auto writer = tree::open_scene(path, job_.scene_format, scene_options(job_, origin));
    hand_over_ = [&writer](std::size_t, GrownTree& grown) { writer->add_tree(grown.tree); };
    WrittenScene written{.name = path.string(), .trees = morphologies_.size()};
    in_blocks("growing", written, [&](std::size_t i) {
      GrownTree grown = grow(i, level);
      grown.file = path.string();
      grown.bytes = tree::glb_mesh_bytes(grown.tree.mesh);
      return grown;
    });
    add_ground(job_, stand_, origin, *writer);
    finish_scene(*writer, written);
    result_.files.push_back(std::move(written));
  }

  // ---- Shared models --------------------------------------------------------------------------

  void share() {
    result_.shared = tree::share_models(morphologies_, builders_, job_.models_per_preset);
    for (const int level : job_.levels) write_shared(level);
  }

  void write_shared(int level) {
    const fs::path path = scene_path(job_, level);
    const tree::Position origin = tree::scene_origin(stand_);
    const auto writer = tree::open_scene(path, job_.scene_format, scene_options(job_, origin));
    std::vector<tree::SceneWriter::Model> models;
    std::vector<std::size_t> triangles;
    for (std::size_t m = 0; m < result_.shared.models.size(); ++m) {
      const tree::SharedModel& model = result_.shared.models[m];
      tree::GrowOptions of_model = grow_options(job_, level);
      // Scaling moves other cross-sections to breast height than the one that all levels keep.
      of_model.mesh.stem_tolerance_m = tree::level_of_detail(0).stem_tolerance_m;
      tree::SceneTree grown = tree::grow_tree(model.morphology, *model.builder, of_model);
      tree::measure_stems(m, grown.mesh, morphologies_, result_.shared);
      grown.mesh = tree::with_joined_wood(std::move(grown.mesh));
      models.push_back(writer->add_model(model.morphology.tree,
                                         tree::parts_of(grown.mesh, model.builder->name())));
      triangles.push_back(grown.measured.triangles);
      job_.show("growing models", models.size(), result_.shared.models.size());
    }
    WrittenScene written{.name = path.string(), .trees = morphologies_.size()};
    for (std::size_t i = 0; i < morphologies_.size(); ++i) {
      const tree::SharedTree& shared = result_.shared.trees[i];
      const tree::Morphology& tree = morphologies_[i];
      writer->place(models[shared.model],
                    tree.plot + "-" + tree.tree,
                    {.position = tree.position,
                     .stretch_east = shared.stretch_east,
                     .stretch_up = shared.stretch_up,
                     .stretch_north = shared.stretch_north},
                    i);
      written.triangles += triangles[shared.model];
    }
    add_ground(job_, stand_, origin, *writer);
    finish_scene(*writer, written);
    result_.files.push_back(std::move(written));
  }

  const GrowJob& job_;
  const std::vector<tree::Morphology>& morphologies_;
  const std::vector<tree::Morphology>& stand_;
  std::vector<tree::PresetChoice> choices_;
  std::vector<const tree::Builder*> builders_{};
  tree::StandOverlap overlap_{};
  GrowResult result_{};
  std::vector<std::string> names_{};
  std::function<void(std::size_t, GrownTree&)> hand_over_{};
};

}  // namespace

GrowResult grow_trees(const GrowJob& job,
                      const std::vector<tree::Morphology>& morphologies,
                      const std::vector<tree::Morphology>& stand,
                      const tree::BuilderCatalogue& catalogue,
                      const tree::Builder* for_all) {
  Grower grower(job, morphologies, stand, catalogue, for_all);
  try {
    return grower.run();
  } catch (const GeometryError& error) {
    Place place = error.place();
    if (place.file.empty()) place.file = place.tree.empty() ? job.scene : job.file;
    throw GeometryError(error.message(), place);
  }
}

}  // namespace silvafit::study
