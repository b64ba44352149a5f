// SPDX-License-Identifier: MIT
// `silvafit grow`: trees and stands as GLB, glTF, OBJ or PLY.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <utility>

#include "grow_command.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/tree/lsystem_builder.hpp"
#include "tree_table.hpp"

namespace silvafit::cli {
namespace {

namespace fs = std::filesystem;

tree::MorphologyTableOptions table_options(const GrowCommand& command) {
  return {.use = tree::use_from_text(command.use),
          .columns = column_map(command.columns),
          .plots = command.plots,
          .needs_position = !command.scene.empty() || command.resolve_overlaps};
}

/// All trees of the table at one time, or the trees of each moment.
tree::Moments read_trees(const GrowCommand& command) {
  const tree::MorphologyTableOptions options = table_options(command);
  const data::Table table = read_tree_table(command.file, options.columns);
  if (!command.by.empty()) return tree::read_moments(table, command.by, options);
  tree::MorphologyTable read = tree::read_morphologies(table, options);
  tree::Moments one{.left_out = std::move(read.left_out)};
  if (!read.morphologies.empty()) one.moments.push_back({.trees = std::move(read.morphologies)});
  return one;
}

/// A file name that no file system objects to; bytes beyond letters, digits, `.`, `_` and `-`
/// become %XX, so that different names stay different.
std::string file_name(const std::string& name) {
  std::string safe;
  for (const char c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '_' || c == '-' ||
                          (c == '.' && !safe.empty());
    if (is_plain) {
      safe += c;
    } else {
      safe += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return safe;
}

std::string level_suffix(const GrowCommand& command, int level) {
  return command.levels.size() > 1 && level > 0 ? fmt::format("-lod{}", level) : std::string();
}

/// Names without level and ending.
std::vector<std::string> file_names(const std::vector<tree::Morphology>& morphologies) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const tree::Morphology& morphology : morphologies) {
    const std::string plain = file_name(morphology.plot + "-" + morphology.tree);
    std::string name = plain;
    // Plot a, tree b-c and plot a-b, tree c share a name; a tilde is in no other.
    for (int copy = 2; !taken.insert(name).second; ++copy) name = plain + fmt::format("~{}", copy);
    names.push_back(std::move(name));
  }
  return names;
}

/// The preset of the L-system builder with the user's own grammar; null if there is none.
std::unique_ptr<const tree::Builder> builder_with_grammar(const tree::BuilderCatalogue& catalogue,
                                                          const GrowCommand& command) {
  if (command.grammar.empty()) return nullptr;
  const tree::Builder& looks = command.preset.empty()
                                   ? catalogue.fallback(command.builder)
                                   : catalogue.named(command.builder, command.preset);
  return dynamic_cast<const tree::LsystemBuilder&>(looks).with_grammar(
      tree::Grammar::load(command.grammar));
}

/// Grows the trees of a table and writes them.
class Grower {
 public:
  /// \param stand    all trees that ground and origin are common to
  /// \param for_all  as listed_builders()
  Grower(const GrowCommand& command,
         const std::vector<tree::Morphology>& morphologies,
         const std::vector<tree::Morphology>& stand,
         const tree::BuilderCatalogue& catalogue,
         const tree::Builder* for_all)
      : command_(command),
        morphologies_(morphologies),
        stand_(stand),
        listed_(listed_builders(morphologies, catalogue, command, for_all)),
        builders_(listed_),
        progress_(command.common) {
    for (const tree::Builder*& builder : builders_) {
      if (builder == nullptr) builder = &catalogue.fallback(command.builder);
    }
  }

  GrowResult run() {
    result_.tree_count = morphologies_.size();
    if (command_.resolve_overlaps) resolve();
    if (command_.share) {
      share();
    } else {
      for (const int level : command_.levels) {
        if (command_.scene.empty()) {
          write_alone(level);
        } else {
          write_scene(level);
        }
      }
    }
    progress_.clear();
    result_.pairs = std::move(overlap_.pairs);
    return std::move(result_);
  }

  const std::vector<const tree::Builder*>& builders() const { return builders_; }

 private:
  unsigned threads() const { return command_.common.threads; }

  tree::GrowOptions options(int level) const {
    return {.seed = command_.common.seed,
            .mesh = tree::level_of_detail(level, {.textured = command_.textures})};
  }

  void resolve() {
    std::vector<tree::StandTree> trees(morphologies_.size());
    std::atomic<std::size_t> done = 0;
    parallel_for(trees.size(), threads(), [&](std::size_t i) {
      trees[i] = tree::grow_for_stand(morphologies_[i], *builders_[i], options(0));
      progress_.show("looking at neighbors", ++done, trees.size());
    });
    overlap_ = tree::resolve_overlaps(trees, threads());
    for (const tree::TreeOverlap& one : overlap_.trees) {
      result_.crossing += one.crossing > 0 ? 1 : 0;
    }
  }

  GrownTree grow(std::size_t i, int level) const {
    const tree::TreeOverlap* overlap = command_.resolve_overlaps ? &overlap_.trees[i] : nullptr;
    GrownTree grown{
        .tree = tree::grow_tree(morphologies_[i], *builders_[i], options(level), overlap),
        .level = level};
    constexpr double kPerMeter = 100.0;
    grown.surface_error_cm = kPerMeter * grown.tree.mesh.surface_error_m;
    if (listed_[i] == nullptr) {
      grown.tree.notes.push_back(
          {"preset", "no preset lists the species: " + builders_[i]->name()});
    }
    return grown;
  }

  /// Counts a tree that is written; its mesh is not kept.
  void take(GrownTree grown) {
    result_.triangles += grown.tree.measured.triangles;
    const bool first_level = grown.level == command_.levels.front();
    const bool guessed =
        std::any_of(grown.tree.notes.begin(), grown.tree.notes.end(), [](const tree::Note& note) {
          return note.about != "overlap";
        });
    result_.with_guesses += first_level && guessed ? 1 : 0;
    grown.tree.mesh = {};
    if (command_.common.json) result_.trees.push_back(std::move(grown));
  }

  /// Grows a few trees at a time on all threads and hands them over in their order, so that memory
  /// does not grow with their number.
  template <typename Each>
  void in_blocks(const char* stage, std::size_t count, Each each) {
    constexpr std::size_t kBlock = 64;
    std::vector<GrownTree> block;
    for (std::size_t from = 0; from < count; from += kBlock) {
      block.assign(std::min(kBlock, count - from), {});
      parallel_for(block.size(), threads(), [&](std::size_t k) { block[k] = each(from + k); });
      for (std::size_t k = 0; k < block.size(); ++k) hand_over_(from + k, block[k]);
      for (GrownTree& grown : block) take(std::move(grown));
      progress_.show(stage, from + block.size(), count);
    }
  }

  void write_alone(int level) {
    if (names_.empty()) names_ = file_names(morphologies_);
    hand_over_ = [](std::size_t, GrownTree&) {};
    in_blocks("growing", morphologies_.size(), [&](std::size_t i) {
      GrownTree grown = grow(i, level);
      const fs::path path =
          fs::path(command_.out) / (names_[i] + level_suffix(command_, level) + "." +
                                    tree::file_ending(command_.scene_format));
      grown.file = path.string();
      const auto writer =
          tree::open_scene(path, command_.scene_format, scene_options(command_, {}));
      // A tree alone stands at the origin.
      tree::SceneTree& alone = grown.tree;
      const tree::Position place = std::exchange(alone.position, {});
      writer->add_tree(alone);
      alone.position = place;
      grown.bytes = writer->finish();
      return grown;
    });
  }

  fs::path scene_path(int level) const {
    fs::path path = command_.scene;
    const std::string suffix = level_suffix(command_, level);
    if (!suffix.empty()) {
      path.replace_filename(path.stem().string() + suffix + path.extension().string());
    }
    return path;
  }

  void write_scene(int level) {
    const fs::path path = scene_path(level);
    const tree::Position origin = tree::scene_origin(stand_);
    const auto writer =
        tree::open_scene(path, command_.scene_format, scene_options(command_, origin));
    hand_over_ = [&writer](std::size_t, GrownTree& grown) { writer->add_tree(grown.tree); };
    in_blocks("growing", morphologies_.size(), [&](std::size_t i) {
      GrownTree grown = grow(i, level);
      grown.file = path.string();
      grown.bytes = tree::glb_mesh_bytes(grown.tree.mesh);
      return grown;
    });
    add_ground(command_, stand_, origin, *writer);
    result_.files.emplace_back(path.string(), writer->finish());
  }

  // ---- Shared models --------------------------------------------------------------------------

  void share() {
    result_.shared = tree::share_models(morphologies_, builders_, command_.models_per_preset);
    for (const int level : command_.levels) write_shared(level);
  }

  void write_shared(int level) {
    const fs::path path = scene_path(level);
    const tree::Position origin = tree::scene_origin(stand_);
    const auto writer =
        tree::open_scene(path, command_.scene_format, scene_options(command_, origin));
    std::vector<tree::SceneWriter::Model> models;
    std::vector<std::size_t> triangles;
    for (const tree::SharedModel& model : result_.shared.models) {
      const tree::SceneTree grown =
          tree::grow_tree(model.morphology, *model.builder, options(level));
      models.push_back(writer->add_model(model.morphology.tree,
                                         tree::parts_of(grown.mesh, model.builder->name())));
      triangles.push_back(grown.measured.triangles);
      progress_.show("growing models", models.size(), result_.shared.models.size());
    }
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
      result_.triangles += triangles[shared.model];
    }
    add_ground(command_, stand_, origin, *writer);
    result_.files.emplace_back(path.string(), writer->finish());
  }

  const GrowCommand& command_;
  const std::vector<tree::Morphology>& morphologies_;
  const std::vector<tree::Morphology>& stand_;
  std::vector<const tree::Builder*> listed_;  ///< null where no preset lists the species
  std::vector<const tree::Builder*> builders_;
  Progress progress_;
  tree::StandOverlap overlap_{};
  GrowResult result_{};
  std::vector<std::string> names_{};
  std::function<void(std::size_t, GrownTree&)> hand_over_{};
};

void check_moments(const GrowCommand& command) {
  if (!command.by.empty() && command.share) {
    throw UsageError("--by gives each tree models of its own: leave out --share");
  }
  if (!command.animate) return;
  if (command.by.empty() || command.scene.empty()) {
    throw UsageError("--animate needs --by, the column with the times, and --scene");
  }
  const bool is_gltf = command.scene_format == tree::SceneFormat::kGlb ||
                       command.scene_format == tree::SceneFormat::kGltf;
  if (!is_gltf) throw UsageError("only glb and gltf hold animations");
  if (command.resolve_overlaps || command.levels.size() > 1) {
    throw UsageError("--animate is for one level of detail, and not with --resolve-overlaps");
  }
}

void check(GrowCommand& command) {
  if (!command.grammar.empty() && command.builder != tree::BuilderKind::kLsystem) {
    throw UsageError("--grammar is for --builder lsystem");
  }
  if (command.scene.empty() == command.out.empty()) {
    throw UsageError("say where the trees go: --scene FILE for all in one, or --out DIR");
  }
  if (command.share && (command.scene.empty() || command.resolve_overlaps)) {
    throw UsageError(
        "--share is for a --scene, and not with --resolve-overlaps, which gives each tree a shape "
        "of "
        "its own");
  }
  if (command.instancing && !command.share) {
    throw UsageError("--instancing needs models that trees share: add --share");
  }
  std::string format = command.format;
  const std::string ending = fs::path(command.scene).extension().string();
  if (format.empty()) format = ending.size() > 1 ? ending.substr(1) : "glb";
  std::sort(command.levels.begin(), command.levels.end());
  command.levels.erase(std::unique(command.levels.begin(), command.levels.end()),
                       command.levels.end());
  for (const int level : command.levels) static_cast<void>(tree::level_of_detail(level));
  command.scene_format = tree::scene_format_from_text(format);
  if (command.textures && command.scene_format == tree::SceneFormat::kPly) {
    throw UsageError("PLY files hold no pictures: --textures is for glb, gltf and obj");
  }
  if (command.models_per_preset == 0) throw UsageError("--models must be at least 1");
  check_moments(command);
}

/// What goes wrong with a tree is said with the table's name, what with a scene with the scene's.
GrowResult run_named(Grower& grower, const GrowCommand& command) {
  try {
    return grower.run();
  } catch (const GeometryError& error) {
    Place place = error.place();
    if (place.file.empty()) place.file = place.tree.empty() ? command.scene : command.file;
    throw GeometryError(error.message(), place);
  }
}

/// The command for one moment: the scene STEM-MOMENT.glb, or the folder OUT/MOMENT.
GrowCommand of_moment(const GrowCommand& command, const tree::Moment& moment, bool is_first) {
  GrowCommand one = command;
  const std::string name = file_name(moment.name);
  if (command.scene.empty()) {
    one.out = (fs::path(command.out) / name).string();
  } else {
    const fs::path path = command.scene;
    fs::path named = path;
    named.replace_filename(path.stem().string() + "-" + name + path.extension().string());
    one.scene = named.string();
  }
  // What is said of species would be said again.
  one.common.quiet = command.common.quiet || !is_first;
  return one;
}

/// Everything that is said of all moments together.
struct Sequence {
  GrowResult result{};
  std::vector<tree::Morphology> morphologies{};
  std::unique_ptr<const tree::Builder> with_grammar{};
  std::vector<const tree::Builder*> builders{};
};

void append(GrowResult&& part, const std::string& moment, std::size_t before, GrowResult& all) {
  for (GrownTree& tree : part.trees) {
    tree.moment = moment;
    all.trees.push_back(std::move(tree));
  }
  for (tree::PairOverlap& pair : part.pairs) {
    pair.weaker += before;
    pair.stronger += before;
    all.pairs.push_back(std::move(pair));
  }
  all.files.insert(all.files.end(), part.files.begin(), part.files.end());
  all.shared = std::move(part.shared);
  all.tree_count += part.tree_count;
  all.triangles += part.triangles;
  all.with_guesses += part.with_guesses;
  all.crossing += part.crossing;
}

Sequence grow_moments(const GrowCommand& command,
                      const std::vector<tree::Moment>& moments,
                      const tree::BuilderCatalogue& catalogue) {
  Sequence all;
  for (const tree::Moment& moment : moments) {
    all.morphologies.insert(all.morphologies.end(), moment.trees.begin(), moment.trees.end());
  }
  all.with_grammar = builder_with_grammar(catalogue, command);
  if (command.animate) {
    all.result =
        write_animation(command, moments, all.morphologies, catalogue, all.with_grammar.get());
    return all;
  }
  std::size_t before = 0;
  for (const tree::Moment& moment : moments) {
    const GrowCommand one = command.by.empty() ? command : of_moment(command, moment, before == 0);
    Grower grower(one, moment.trees, all.morphologies, catalogue, all.with_grammar.get());
    append(run_named(grower, one), moment.name, before, all.result);
    all.builders.insert(all.builders.end(), grower.builders().begin(), grower.builders().end());
    before += moment.trees.size();
  }
  return all;
}

void run(GrowCommand& command) {
  check(command);
  const auto start = std::chrono::steady_clock::now();
  const auto catalogue = tree::BuilderCatalogue::load(data_directory() / "models");
  const tree::Moments table = read_trees(command);
  report_left_out(command, table.left_out);
  if (table.moments.empty()) {
    throw InputError("no tree can be grown from its rows", {.file = command.file});
  }
  const Sequence all = grow_moments(command, table.moments, catalogue);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  report_grown(
      command, all.result, all.morphologies, all.builders, table.left_out, seconds.count());
}

}  // namespace

void add_grow_command(CLI::App& program) {
  auto options = std::make_shared<GrowCommand>();
  CLI::App* command =
      program.add_subcommand("grow", "Grow measured or predicted trees as 3D models");
  command->add_option("morphology", options->file, "CSV of an inventory or of predictions")
      ->required()
      ->type_name("FILE.csv");
  command
      ->add_option(
          "--use", options->use, "Which h, hcb and cw: observed, ols, population, conditional")
      ->capture_default_str();
  command->add_option(
      "--preset", options->preset, "Species preset for all trees (default: by species)");
  command->add_option("--scene", options->scene, "One file with all trees at their places")
      ->type_name("FILE");
  command->add_option("--out", options->out, "Folder for one file a tree, at the origin")
      ->type_name("DIR");
  command
      ->add_option("--format",
                   options->format,
                   "glb, gltf, obj or ply (default: by the ending of --scene, else glb)")
      ->check(CLI::IsMember({"glb", "gltf", "obj", "ply"}));
  command->add_flag("--resolve-overlaps",
                    options->resolve_overlaps,
                    "Remove and turn branches where neighbors' crowns overlap");
  command
      ->add_option("--lod",
                   options->levels,
                   "Level of detail, 0 (finest) to 3; several, as in 0,2, go to files of their own")
      ->delimiter(',')
      ->capture_default_str();
  command
      ->add_option(
          "--ground", options->ground, "Ground of a scene: through the stems' feet, flat, or none")
      ->check(CLI::IsMember({"stems", "flat", "none"}))
      ->capture_default_str();
  command->add_flag("--share",
                    options->share,
                    "Trees of like shape share a model, stretched to height and width");
  command->add_option("--models", options->models_per_preset, "Models a preset with --share")
      ->capture_default_str();
  command->add_flag("--instancing",
                    options->instancing,
                    "GLB, glTF: EXT_mesh_gpu_instancing for trees that share a model");
  command->add_flag("--quantize", options->quantize, "GLB, glTF: KHR_mesh_quantization");
  command->add_flag(
      "--compress", options->compress, "GLB, glTF: EXT_meshopt_compression and quantization");
  command->add_flag("--ascii", options->ascii, "PLY as text");
  command->add_flag(
      "--textures", options->textures, "GLB, glTF, OBJ: pictures of bark and leaves in the file");
  command
      ->add_option_function<std::string>(
          "--builder",
          [options](const std::string& name) { options->builder = tree::builder_from_text(name); },
          "How trees are built (their presets: silvafit models --builders)")
      ->check(CLI::IsMember({"segment", "lsystem", "ifs", "bamboo"}))
      ->default_str("segment");
  command
      ->add_option("--grammar",
                   options->grammar,
                   "L-system of your own for all trees, with --builder lsystem; the preset gives "
                   "crown, taper, bark and leaves")
      ->type_name("FILE.lsys");
  command->add_option("--plot", options->plots, "Plots to grow, separated by commas (default: all)")
      ->delimiter(',');
  command
      ->add_option("--columns",
                   options->columns,
                   "Other names or units of columns, as in h=H_m,dbh=DBH_mm/10")
      ->delimiter(',');
  command->add_option(
      "--by",
      options->by,
      "Column with the time of each row, such as year: a scene a time, FILE-2021.glb, "
      "FILE-2022.glb, ...");
  command->add_flag("--animate",
                    options->animate,
                    "GLB, glTF: one scene in which the trees of --by grow over time");
  command
      ->add_option("--seconds",
                   options->seconds_per_unit,
                   "Of the animation a unit of --by, or a step where it holds text")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  add_common_options(*command, options->common);
  add_example(*command,
              "silvafit grow examples/fir-mixed/inventory.csv --plot 1 --scene plot1.glb");
  command->callback([options] { run(*options); });
}

}  // namespace silvafit::cli
