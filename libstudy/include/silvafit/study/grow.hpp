// SPDX-License-Identifier: MIT
// Growing the trees of a table into files: a scene of a stand, or one file per tree.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/growth.hpp"
#include "silvafit/tree/morphology_table.hpp"
#include "silvafit/tree/overlap.hpp"
#include "silvafit/tree/scene_writer.hpp"
#include "silvafit/tree/shared_models.hpp"

namespace silvafit::study {

/// The ground of a scene.
enum class SceneGround {
  kStems,  ///< through the stem bases
  kFlat,   ///< at the lowest stem base
  kNone,
};
constexpr std::array<std::string_view, 3> words_of(SceneGround /*ground*/) {
  return {"stems", "flat", "none"};
}

struct GrowSettings {
  ReadingSettings reading{};
  std::vector<std::string> plots{};  ///< plots to grow; empty: all
  std::string use = "observed";      ///< source of h, hcb and cw, a word of tree::Use
  // What is written: one of the two.
  std::string scene{};      ///< file of all trees at their positions
  std::string out{};        ///< folder of one file per tree, at the origin, or per plot
  bool is_by_plot = false;  ///< one file per plot in `out`, not per tree
  std::optional<tree::SceneFormat> format{};  ///< none: from the ending of `scene`, else GLB
  // How trees look.
  tree::BuilderKind builder = tree::BuilderKind::kSegment;
  std::string preset{};      ///< of the builder, for all trees; empty: by species
  std::string grammar{};     ///< file of an L-system grammar for all trees
  bool is_unfitted = false;  ///< grammars and function systems as they are, scaled to the height
  /// Of detail, 0 (finest) to 3, or 4 for impostors; each has files of its own.
  std::vector<int> levels{0};
  bool resolve_overlaps = false;       ///< remove and turn branches where crowns overlap
  bool share = false;                  ///< trees of similar shape share a model
  std::size_t models_per_preset = 64;  ///< with `share`
  bool dead_wood = false;              ///< dead trees as snags, cut ones as stumps, fallen as logs
  SceneGround ground = SceneGround::kStems;
  // How files are written; tree::SceneOptions explains them.
  bool instancing = false;
  bool quantize = false;
  bool compress = false;
  bool ascii = false;
  bool textures = true;  ///< PLY has none
  tree::Season season = tree::Season::kSummer;
  // Repeated measurements.
  std::string by{};               ///< column of the time; one scene a time: FILE-2021.glb, ...
  bool animate = false;           ///< one animated scene of all times instead
  double seconds_per_unit = 1.0;  ///< of the animation, by unit of `by`
  bool keeps_trees = false;       ///< the result has an entry for each tree
  std::string manifest{};         ///< CSV file with a row for each tree at each level of detail
  /// Reads a CSV file plot by plot and writes trees while others are read, so that memory does not
  /// grow with their number; if the rows of a plot are not contiguous, they are sorted on disk. The
  /// result has counts and files only.
  bool stream = false;
  bool is_part = false;  ///< of an inventory: without usable rows, nothing is written
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: as many as there are cores
};

/// The results for a tree at one level of detail.
struct GrownTree {
  tree::SceneTree tree{};  ///< without its mesh
  std::string file{};
  std::size_t bytes = 0;  ///< of its file, or of its mesh in the scene
  int level = 0;
  double surface_error_cm = 0.0;
  std::string moment{};  ///< with `by`
};

/// A scene that was written, or the files of one level of detail in a folder.
struct WrittenScene {
  std::string name{};  ///< the scene's file; the folder, with the ending of a level's files
  std::size_t bytes = 0;
  std::size_t trees = 0;
  std::size_t triangles = 0;  ///< as drawn
  /// Companion files: the buffer of glTF, materials and textures of OBJ.
  std::vector<std::string> beside{};
};

/// Trees are counted once for all their measurements.
struct GrowCounts {
  std::size_t trees = 0;
  std::size_t with_guesses = 0;  ///< with missing measurements
  /// Trees by what they lack, or what was not used as measured: hc, radii, preset, branch_count.
  std::map<std::string, std::size_t> guesses{};
  std::size_t crossing = 0;  ///< whose radius branches cross those of neighbors
  std::size_t overlaps = 0;  ///< pairs of crowns
};

struct GrowResult {
  GrowSettings settings{};
  GrowCounts counts{};
  std::size_t moments = 0;
  std::vector<tree::Morphology> morphologies{};  ///< of all moments, one after the other
  std::vector<tree::LeftOut> left_out{};         ///< rows that cannot be used
  std::vector<GrownTree> trees{};                ///< with `keeps_trees`
  std::vector<std::string> presets{};            ///< of all trees, except with `animate`
  std::vector<tree::PairOverlap> pairs{};        ///< with `resolve_overlaps`
  tree::SharedModels shared{};  ///< with `share`; its builders are those of the catalogue
  std::vector<WrittenScene> files{};
  std::vector<std::size_t> with_guesses{};  ///< indices of trees with missing measurements
  /// Indices of trees whose radius branches cross those of neighbors.
  std::vector<std::size_t> crossing{};
  double seconds = 0.0;
};

/// Grows the trees of a table and writes their files.
/// \throws UsageError for settings that cannot be combined; InputError if no row can be used; else
///   as read_tree_table, tree::read_morphologies and tree::grow_tree
GrowResult grow(const data::TableSource& trees,
                const tree::BuilderCatalogue& catalogue,
                const GrowSettings& settings,
                const Callbacks& callbacks = {});

/// As JSON, schema silvafit-grow/1 (docs/json.md).
nlohmann::ordered_json json_of(const GrowResult& result);

/// The largest differences between trees and the models that they share.
tree::ShapeError worst_of(const tree::SharedModels& shared);

/// Sentences on skipped rows: the first twenty, and how many more there are.
/// \param count  of all skipped rows, if the list has only the first of them
std::vector<std::string> notes_on(const std::vector<tree::LeftOut>& left_out,
                                  std::size_t count = 0);

}  // namespace silvafit::study
