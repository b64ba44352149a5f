// SPDX-License-Identifier: MIT
// Common parts of `silvafit grow`: its options, and the results for a tree.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "command.hpp"
#include "sheet_options.hpp"
#include "silvafit/tree/growth.hpp"
#include "silvafit/tree/morphology_table.hpp"
#include "silvafit/tree/overlap.hpp"
#include "silvafit/tree/scene_writer.hpp"
#include "silvafit/tree/shared_models.hpp"

namespace silvafit::cli {

struct GrowCommand {
  CommonOptions common;
  std::string file;
  std::string use = "observed";
  std::string preset;
  std::string grammar;
  std::string scene;
  std::string out;
  tree::BuilderKind builder = tree::BuilderKind::kSegment;
  std::string format;
  std::string ground = "stems";
  std::vector<std::string> plots;
  std::vector<std::string> columns;
  SheetArguments sheet{};
  std::string by;
  bool animate = false;
  double seconds_per_unit = 1.0;
  std::vector<int> levels{0};
  std::size_t models_per_preset = 64;
  bool resolve_overlaps = false;
  bool share = false;
  bool instancing = false;
  bool quantize = false;
  bool compress = false;
  bool ascii = false;
  bool textures = false;
  tree::SceneFormat scene_format = tree::SceneFormat::kGlb;
};

/// The results for a tree at one level of detail.
struct GrownTree {
  tree::SceneTree tree{};  ///< without its mesh
  std::string file{};
  std::size_t bytes = 0;  ///< of its file, or of its mesh in the scene
  int level = 0;
  double surface_error_cm = 0.0;
  std::string moment{};  ///< with --by
};

/// A scene that was written, or the files of one level of detail in a folder.
struct Written {
  std::string name{};  ///< the scene's file; the folder, with the ending of a level's files
  std::size_t bytes = 0;
  std::size_t trees = 0;
  std::size_t triangles = 0;  ///< as drawn
  /// Companion files: the buffer of glTF, materials and textures of OBJ.
  std::vector<std::string> beside{};
};

/// All results of a run.
struct GrowResult {
  std::vector<GrownTree> trees{};                ///< only with --json
  std::vector<const tree::Builder*> builders{};  ///< of all trees, except with --animate
  std::vector<tree::PairOverlap> pairs{};        ///< with --resolve-overlaps
  tree::SharedModels shared{};                   ///< with --share
  std::vector<Written> files{};
  /// Indices of trees with missing measurements.
  std::vector<std::size_t> with_guesses{};
  /// Indices of trees whose radius branches cross those of neighbors.
  std::vector<std::size_t> crossing{};
};

/// The options of the command, except the common ones.
/// \param options  is filled when the command line is parsed
void add_grow_options(CLI::App& command, GrowCommand& options);

/// Fills in values that follow from the options: the scene's format, sorted levels.
/// \throws UsageError for options that cannot be combined
void check_and_complete(GrowCommand& command);

/// Unique file names for the trees, without level and ending.
std::vector<std::string> tree_names(const std::vector<tree::Morphology>& morphologies);

/// The file of one tree (--out).
/// \param name  of tree_names()
std::filesystem::path tree_path(const GrowCommand& command, const std::string& name, int level);

/// The description of the trees' files of a level (--out): the folder, and the file name ending if
/// there are several levels.
std::string folder_text(const GrowCommand& command, int level);

/// The file of all trees (--scene).
std::filesystem::path scene_path(const GrowCommand& command, int level);

/// The command for one moment: the scene STEM-MOMENT.glb, or the folder OUT/MOMENT.
GrowCommand of_moment(const GrowCommand& command, const tree::Moment& moment);

/// Each tree's builder with the requested preset, or that of the species; null if no preset lists
/// it, with a message.
std::vector<const tree::Builder*> listed_builders(const std::vector<tree::Morphology>& morphologies,
                                                  const tree::BuilderCatalogue& catalogue,
                                                  const GrowCommand& command,
                                                  const tree::Builder* for_all);

tree::SceneOptions scene_options(const GrowCommand& command, const tree::Position& origin);

/// The ground under these stems according to --ground.
void add_ground(const GrowCommand& command,
                const std::vector<tree::Morphology>& stems,
                const tree::Position& origin,
                tree::SceneWriter& writer);

/// Writes the file of a scene, and stores its size and companion files.
/// \throws as SceneWriter::finish()
void finish_scene(tree::SceneWriter& writer, Written& written);

/// Grows the trees of one time and writes them.
/// \param stand    all trees that share the ground and the origin
/// \param for_all  as listed_builders()
/// \throws GeometryError with the table's name for a tree, with the scene's for the whole
GrowResult grow_trees(const GrowCommand& command,
                      const std::vector<tree::Morphology>& morphologies,
                      const std::vector<tree::Morphology>& stand,
                      const tree::BuilderCatalogue& catalogue,
                      const tree::Builder* for_all);

/// One file with the trees of all moments in sequence (--animate).
/// \param stand  all trees of all moments
GrowResult write_animation(const GrowCommand& command,
                           const std::vector<tree::Moment>& moments,
                           const std::vector<tree::Morphology>& stand,
                           const tree::BuilderCatalogue& catalogue,
                           const tree::Builder* for_all);

/// Prints the result as text or as JSON.
/// \param morphologies  of all moments, one after the other
/// \param moments       number of moments
void report_grown(const GrowCommand& command,
                  const GrowResult& result,
                  const std::vector<tree::Morphology>& morphologies,
                  std::size_t moments,
                  const std::vector<tree::LeftOut>& left_out,
                  double seconds);

/// Reports the skipped rows, the first twenty of them.
void report_left_out(const GrowCommand& command, const std::vector<tree::LeftOut>& left_out);

/// Reports plots that cover each other at one of the moments.
void report_coinciding_plots(const GrowCommand& command, const std::vector<tree::Moment>& moments);

}  // namespace silvafit::cli
