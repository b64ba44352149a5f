// SPDX-License-Identifier: MIT
// What the parts of `silvafit grow` share: its options, and what is reported of a tree.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "command.hpp"
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

/// What is reported of a tree at one level of detail.
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
  /// Files that belong to it: the buffer of glTF, materials and pictures of OBJ.
  std::vector<std::string> beside{};
};

/// Everything that is grown, and what was found out on the way.
struct GrowResult {
  std::vector<GrownTree> trees{};                ///< only with --json
  std::vector<const tree::Builder*> builders{};  ///< of all trees, but with --animate
  std::vector<tree::PairOverlap> pairs{};        ///< with --resolve-overlaps
  tree::SharedModels shared{};                   ///< with --share
  std::vector<Written> files{};
  /// Numbers of trees with parts that were not measured.
  std::vector<std::size_t> with_guesses{};
  /// Numbers of trees whose radius branches could not be parted from neighbors'.
  std::vector<std::size_t> crossing{};
};

/// The options of the command but for the common ones.
/// \param options  is filled when the command line is read
void add_grow_options(CLI::App& command, GrowCommand& options);

/// Fills in what follows from the options: the scene's format, levels in order.
/// \throws UsageError for options that do not go together
void check_and_complete(GrowCommand& command);

/// Names of files for the trees, without level and ending; no two are the same.
std::vector<std::string> tree_names(const std::vector<tree::Morphology>& morphologies);

/// The file of one tree (--out).
/// \param name  of tree_names()
std::filesystem::path tree_path(const GrowCommand& command, const std::string& name, int level);

/// What is told of the trees' files of a level (--out): the folder, and how their names end where
/// there are several levels.
std::string folder_text(const GrowCommand& command, int level);

/// The file of all trees (--scene).
std::filesystem::path scene_path(const GrowCommand& command, int level);

/// The command for one moment: the scene STEM-MOMENT.glb, or the folder OUT/MOMENT.
GrowCommand of_moment(const GrowCommand& command, const tree::Moment& moment);

/// Each tree's builder with the preset that was asked for, or the species' own; null where no
/// preset lists it, which is said.
std::vector<const tree::Builder*> listed_builders(const std::vector<tree::Morphology>& morphologies,
                                                  const tree::BuilderCatalogue& catalogue,
                                                  const GrowCommand& command,
                                                  const tree::Builder* for_all);

tree::SceneOptions scene_options(const GrowCommand& command, const tree::Position& origin);

/// The ground that the command asks for, under these stems.
void add_ground(const GrowCommand& command,
                const std::vector<tree::Morphology>& stems,
                const tree::Position& origin,
                tree::SceneWriter& writer);

/// Writes what was added to a scene, and notes its size and the files beside it.
/// \throws as SceneWriter::finish()
void finish_scene(tree::SceneWriter& writer, Written& written);

/// Grows the trees of one time and writes them.
/// \param stand    all trees that ground and origin are common to
/// \param for_all  as listed_builders()
/// \throws GeometryError with the table's name for a tree, with the scene's for the whole
GrowResult grow_trees(const GrowCommand& command,
                      const std::vector<tree::Morphology>& morphologies,
                      const std::vector<tree::Morphology>& stand,
                      const tree::BuilderCatalogue& catalogue,
                      const tree::Builder* for_all);

/// One file in which the trees of the moments follow each other (--animate).
/// \param stand  all trees of all moments
GrowResult write_animation(const GrowCommand& command,
                           const std::vector<tree::Moment>& moments,
                           const std::vector<tree::Morphology>& stand,
                           const tree::BuilderCatalogue& catalogue,
                           const tree::Builder* for_all);

/// Prints the result for people, or as JSON.
/// \param morphologies  of all moments, one after the other
/// \param moments       how many there are
void report_grown(const GrowCommand& command,
                  const GrowResult& result,
                  const std::vector<tree::Morphology>& morphologies,
                  std::size_t moments,
                  const std::vector<tree::LeftOut>& left_out,
                  double seconds);

/// Names the rows that no tree can be grown from, the first twenty of them.
void report_left_out(const GrowCommand& command, const std::vector<tree::LeftOut>& left_out);

/// Says where trees of two plots stand among each other at one of the moments.
void report_coinciding_plots(const GrowCommand& command, const std::vector<tree::Moment>& moments);

}  // namespace silvafit::cli
