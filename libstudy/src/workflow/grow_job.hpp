// SPDX-License-Identifier: MIT
// Common parts of growing: checks of settings, names of files, builders, the ground.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "silvafit/study/grow.hpp"

namespace silvafit::study {

/// Names that are in use, as hashes of 64 bits, so that memory does not grow much with their
/// number: of ten million names, two have the same hash with a probability of 3e-6; one of them
/// then gets a number that it does not need.
class TakenNames {
 public:
  /// Whether the name was free; it is in use now.
  bool take(std::string_view name);

 private:
  std::vector<std::uint64_t> sorted_{};
  std::unordered_set<std::uint64_t> recent_{};
};

/// What all jobs of a growth share.
struct GrowState {
  TakenNames names{};               ///< of files of trees and plots, in small letters
  tree::SharedPictures pictures{};  ///< of OBJ files of trees
  tree::SpeciesNotes species{};
  bool reads_codes = true;      ///< numbers of species are codes of FIA
  tree::Impostors impostors{};  ///< of the coarsest level
  /// Called for each written tree, by its number in the result.
  std::function<void(std::size_t tree, const GrownTree&)> each_tree{};
};

/// Settings with values that follow from them.
struct GrowJob : GrowSettings {
  tree::SceneFormat scene_format = tree::SceneFormat::kGlb;
  std::string file{};  ///< of the table
  Callbacks callbacks{};
  GrowState* state = nullptr;
  std::size_t first_tree = 0;  ///< number of the job's first tree in the result

  void show(const std::string& stage, std::size_t done, std::size_t total) const {
    if (callbacks.progress) callbacks.progress(stage, done, total);
  }
};

/// Fills in values that follow from the settings: the scene's format, sorted levels.
/// \throws UsageError for settings that cannot be combined
GrowJob grow_job(const GrowSettings& settings, const std::string& file, const Callbacks& callbacks);

/// Unique file names for the trees, without level and ending.
std::vector<std::string> tree_names(const GrowJob& job,
                                    const std::vector<tree::Morphology>& morphologies);

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

/// The job of one plot: the scene OUT/PLOT.glb.
GrowJob of_plot(const GrowJob& job, const std::string& plot);

/// Each tree's builder with the requested preset, or that of the species. GrowState has what was
/// assumed about species.
/// \param for_all  the builder of all trees; null: none
std::vector<tree::PresetChoice> choose_builders(const std::vector<tree::Morphology>& morphologies,
                                                const tree::BuilderCatalogue& catalogue,
                                                const GrowJob& job,
                                                const tree::Builder* for_all);

/// How the trees of a level of detail are grown.
tree::GrowOptions grow_options(const GrowJob& job, int level);

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
/// \param for_all  as choose_builders()
/// \throws GeometryError with the table's name for a tree, with the scene's for the whole
GrowResult grow_trees(const GrowJob& job,
                      const std::vector<tree::Morphology>& morphologies,
                      const std::vector<tree::Morphology>& stand,
                      const tree::BuilderCatalogue& catalogue,
                      const tree::Builder* for_all);

/// Grows the trees of all moments, or of all plots (`per`), and writes them.
GrowResult grow_moments(const GrowJob& job,
                        const std::vector<tree::Moment>& moments,
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
