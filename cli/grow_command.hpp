// SPDX-License-Identifier: MIT
// What the parts of `silvafit grow` share: its options, and what is reported of a tree.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "command.hpp"
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
  std::string scene;
  std::string out;
  tree::BuilderKind builder = tree::BuilderKind::kSegment;
  std::string format;
  std::string ground = "stems";
  std::vector<std::string> plots;
  std::vector<std::string> columns;
  std::vector<int> levels{0};
  std::size_t models_per_preset = 64;
  bool resolve_overlaps = false;
  bool share = false;
  bool instancing = false;
  bool quantize = false;
  bool compress = false;
  bool ascii = false;
  tree::SceneFormat scene_format = tree::SceneFormat::kGlb;
};

/// What is reported of a tree at one level of detail.
struct GrownTree {
  tree::SceneTree tree{};  ///< without its mesh
  std::string file{};
  std::size_t bytes = 0;  ///< of its file, or of its mesh in the scene
  int level = 0;
  double surface_error_cm = 0.0;
};

/// Everything that is grown, and what was found out on the way.
struct GrowResult {
  std::vector<GrownTree> trees{};                            ///< only with --json
  std::vector<tree::PairOverlap> pairs{};                    ///< with --resolve-overlaps
  tree::SharedModels shared{};                               ///< with --share
  std::vector<std::pair<std::string, std::size_t>> files{};  ///< scenes with their bytes
  std::size_t tree_count = 0;
  std::size_t triangles = 0;  ///< as drawn
  std::size_t with_guesses = 0;
  std::size_t crossing = 0;  ///< trees whose radius branches could not be parted from neighbours'
};

/// Prints the result for people, or as JSON.
void report_grown(const GrowCommand& command,
                  const GrowResult& result,
                  const std::vector<tree::Morphology>& morphologies,
                  const std::vector<const tree::Builder*>& builders,
                  const std::vector<tree::LeftOut>& left_out,
                  double seconds);

/// Names the rows that no tree can be grown from, the first twenty of them.
void report_left_out(const GrowCommand& command, const std::vector<tree::LeftOut>& left_out);

}  // namespace silvafit::cli
