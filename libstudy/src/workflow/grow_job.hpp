// SPDX-License-Identifier: MIT
// Common parts of growing: checks of settings, names of files, builders, the ground.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "silvafit/study/grow.hpp"

namespace silvafit::study {

/// Settings with values that follow from them.
struct GrowJob : GrowSettings {
  tree::SceneFormat scene_format = tree::SceneFormat::kGlb;
  std::string file{};  ///< of the table
  Callbacks callbacks{};

  void show(const std::string& stage, std::size_t done, std::size_t total) const {
    if (callbacks.progress) callbacks.progress(stage, done, total);
  }
};

/// Fills in values that follow from the settings: the scene's format, sorted levels.
/// \throws UsageError for settings that cannot be combined
GrowJob grow_job(const GrowSettings& settings, const std::string& file, const Callbacks& callbacks);

/// Unique file names for the trees, without level and ending.
std::vector<std::string> tree_names(const std::vector<tree::Morphology>& morphologies);

/// The file of one tree.
/// \param name  of tree_names()
std::filesystem::path tree_path(const GrowJob& job, const std::string& name, int level);

/// The description of a level's files: the folder, and the file name ending if there
/// are several levels.
std::string folder_text(const GrowJob& job, int level);

/// The file of all trees.
std::filesystem::path scene_path(const GrowSettings& settings, int level);

/// The job of one moment: the scene STEM-MOMENT.glb, or the folder OUT/MOMENT.
GrowJob of_moment(const GrowJob& job, const tree::Moment& moment);

/// Each tree's builder with the requested preset, or that of the species; null if no preset lists
/// it, with a note.
/// \param for_all  the builder of all trees; null: none
std::vector<const tree::Builder*> listed_builders(const std::vector<tree::Morphology>& morphologies,
                                                  const tree::BuilderCatalogue& catalogue,
                                                  const GrowJob& job,
                                                  const tree::Builder* for_all);

tree::SceneOptions scene_options(const GrowJob& job, const tree::Position& origin);

/// The ground under these stems.
void add_ground(const GrowJob& job,
                const std::vector<tree::Morphology>& stems,
                const tree::Position& origin,
                tree::SceneWriter& writer);

/// Writes the file of a scene, and stores its size and companion files.
/// \throws as SceneWriter::finish()
void finish_scene(tree::SceneWriter& writer, WrittenScene& written);

/// Grows the trees of one time and writes them.
/// \param stand    all trees that share the ground and the origin
/// \param for_all  as listed_builders()
/// \throws GeometryError with the table's name for a tree, with the scene's for the whole
GrowResult grow_trees(const GrowJob& job,
                      const std::vector<tree::Morphology>& morphologies,
                      const std::vector<tree::Morphology>& stand,
                      const tree::BuilderCatalogue& catalogue,
                      const tree::Builder* for_all);

/// One file with the trees of all moments in sequence.
/// \param stand  all trees of all moments
GrowResult write_animation(const GrowJob& job,
                           const std::vector<tree::Moment>& moments,
                           const std::vector<tree::Morphology>& stand,
                           const tree::BuilderCatalogue& catalogue,
                           const tree::Builder* for_all);

}  // namespace silvafit::study
