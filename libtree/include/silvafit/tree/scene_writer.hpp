// SPDX-License-Identifier: MIT
// Scenes as files, written one model and one position at a time: GLB, glTF, OBJ, PLY.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/scene.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

enum class SceneFormat { kGlb, kGltf, kObj, kPly };
/// The words are the endings of file names, without the dot.
constexpr std::array<std::string_view, 4> words_of(SceneFormat /*format*/) {
  return {"glb", "gltf", "obj", "ply"};
}

/// The pictures of OBJ files in one folder, which share them. Several threads may use it.
class SharedPictures {
 public:
  /// Writes a picture to a folder, once, and gives it a name of its own: that of the texture, with
  /// a number if another picture has this name. \returns the file's path
  std::filesystem::path add(const std::filesystem::path& folder,
                            const std::shared_ptr<const Texture>& texture);

 private:
  std::mutex mutex_{};
  std::map<std::filesystem::path, std::shared_ptr<const std::string>> files_{};
};

/// A time of an animation in the table's own units, such as a year.
struct NamedTime {
  double time_s = 0.0;
  std::string name{};
};

struct SceneOptions {
  Position origin{};  ///< positions in the file are relative to it
  /// GLB and glTF: one node for all instances of a model (EXT_mesh_gpu_instancing), 24 to 28 bytes
  /// per instance. three.js supports it; Blender and assimp do not.
  bool instancing = false;
  /// GLB and glTF: positions in 16 bits, normals in 8 (KHR_mesh_quantization). A vertex moves by at
  /// most 1/65534 of the model's largest extent from its stem's base, in each direction.
  bool quantize = false;
  /// GLB and glTF: buffers compressed by meshoptimizer (EXT_meshopt_compression); implies quantize.
  bool compress = false;
  bool ascii = false;    ///< PLY as text
  unsigned threads = 1;  ///< GLB and glTF: for compressing pictures; 0: one for each core
  /// OBJ: pictures that this file shares with others of its folder; null: it has its own.
  SharedPictures* pictures = nullptr;
  std::vector<NamedTime> times{};  ///< of an animation, in its extras
  /// GLB: the longest file that is written, in bytes. The format has 32 bits for its length.
  std::size_t longest_glb = std::numeric_limits<std::uint32_t>::max();
};

/// Position of a model, and its scale relative to the base of its stem.
struct Placement {
  Position position{};
  double stretch_east = 1.0;
  double stretch_up = 1.0;
  double stretch_north = 1.0;
};

/// Triangles of one material, of the ground or of a tree.
struct ModelPart {
  std::string part{};      ///< "stem", "branches", "foliage", "ground"
  std::string material{};  ///< parts with the same material name share the material of the first
  const MeshPart* mesh = nullptr;
};

/// The parts of a tree of a preset: materials PRESET-bark and PRESET-leaf, or PRESET-VARIANT-leaf.
std::vector<ModelPart> parts_of(const Mesh& mesh, const std::string& preset);

/// A scale at a time.
struct Keyframe {
  double time_s = 0.0;
  std::array<double, 3> scale{1.0, 1.0, 1.0};  ///< east, up, north
};

/// A model that is visible for part of an animation and may grow meanwhile.
struct AnimatedModel {
  std::size_t model = 0;          ///< index of the animation in its writer
  std::string name{};             ///< the time of its measurements
  std::vector<Keyframe> shown{};  ///< scales 1 or 0, each until the next one
  std::vector<Keyframe> size{};   ///< linear interpolation between them; or none
  bool at_rest = false;           ///< whether it is visible if no animation is played
};

/// A file under construction. Meshes are written immediately and not kept, so that memory does
/// not grow with the number of trees (OBJ and PLY, which have no shared meshes, keep the models
/// that are placed more than once). Without finish() no file is left.
class SceneWriter {
 public:
  using Model = std::size_t;

  virtual ~SceneWriter() = default;
  SceneWriter() = default;
  SceneWriter(const SceneWriter&) = delete;
  SceneWriter& operator=(const SceneWriter&) = delete;

  /// A model that can be placed any number of times.
  /// \throws GeometryError naming the model if it has no triangles
  virtual Model add_model(const std::string& name, const std::vector<ModelPart>& parts) = 0;

  /// The number for something that is not a tree.
  static constexpr std::size_t kNoTree = std::numeric_limits<std::size_t>::max();

  /// \param number  index of the tree in its table, for files that cannot name each tree; others
  ///                get a node of their own
  virtual void place(Model model,
                     const std::string& name,
                     const Placement& placement,
                     std::size_t number) = 0;

  /// A tree with its own model and its measurements in the extras.
  virtual void add_tree(const SceneTree& tree) = 0;

  /// Several models of one tree at successive times, at the same position.
  /// \param extras  JSON about the tree, or empty
  /// \throws UsageError for formats without animations
  virtual void animate(const std::string& name,
                       const Position& position,
                       const std::vector<AnimatedModel>& models,
                       const std::string& extras);

  /// Writes the file, completely or not at all; nothing may be added afterwards.
  /// \return bytes of all files written
  /// \throws IoError if it cannot be written; GeometryError if nothing was added, or the
  /// format's size is exceeded
  virtual std::size_t finish() = 0;

  /// The companion files in the same folder, if the format has any: the buffer of glTF, the
  /// materials and textures of OBJ. Known after everything is added.
  virtual std::vector<std::filesystem::path> other_files() const { return {}; }
};

/// The extras of a tree in GLB and glTF: its names and measurements, as JSON.
std::string tree_extras(const SceneTree& tree);

/// \param path  file to write; the buffer of glTF and the materials of OBJ are written to the same
/// folder with the same name
std::unique_ptr<SceneWriter> open_scene(const std::filesystem::path& path,
                                        SceneFormat format,
                                        const SceneOptions& options = {});

}  // namespace silvafit::tree
