// SPDX-License-Identifier: MIT
// Reads GLB and glTF scenes, compressed or not.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/morphology.hpp"

namespace silvafit::tree {

/// The largest GLB file, whose header has 32 bits for its size [bytes]; also that of the files of a
/// glTF scene.
inline constexpr std::uint64_t kLargestScene = std::uint64_t{1} << 32U;

/// Triangles of one material as floats, for any format in the file.
struct ReadPart {
  std::string part{};      ///< "stem", "branches", ... if the file contains it
  std::string material{};  ///< name
  MeshPart mesh{};
};

struct ReadModel {
  std::string name{};
  std::vector<ReadPart> parts{};
};

/// Whether a transformation (column by column, as in glTF) scales to a plane, a line or a point.
bool is_flattened(const std::array<double, 16>& transform);

/// A model at its position.
struct ReadInstance {
  std::string name{};  ///< of its node
  std::size_t model = 0;
  std::array<double, 16> transform{};  ///< column by column, as in glTF
  double tree = -1.0;                  ///< index of the tree in its table, if the file contains it

  /// A point of the model, x y z with y up, in the scene.
  std::array<double, 3> moved(std::array<double, 3> point) const;
};

/// A node of the file.
struct ReadNode {
  std::string name{};
  std::array<double, 16> transform{};  ///< to the scene, column by column; zeros if it is not in it
  bool is_shown = false;  ///< a mesh at or below it is in the scene, with a size that is not zero
};

struct ReadScene {
  std::string file{};  ///< that it was read from; empty if from memory
  Position origin{};
  std::vector<ReadModel> models{};
  std::vector<ReadInstance> instances{};
  std::vector<ReadNode> nodes{};  ///< in the order of the file

  std::size_t triangle_count() const;  ///< as drawn: those of every instance
};

/// Reads the default scene: uncompressed and quantized attributes (KHR_mesh_quantization), buffers
/// compressed by meshoptimizer (EXT_meshopt_compression), shared meshes and instances
/// (EXT_mesh_gpu_instancing), base color textures and normal maps that are PNG in a buffer; a
/// picture in a file of its own is refused. Nodes with scale 0 are skipped. Everything is checked
/// before it is used: sizes, indices, references, and that a scene takes no more memory than 512 MB
/// and 256 times its file.
/// \throws InputError with the file and the reason
ReadScene read_scene(const std::filesystem::path& path);

/// A GLB file in memory.
/// \throws InputError
ReadScene read_glb(std::string_view bytes);

/// The JSON object in a GLB file.
/// \throws InputError
nlohmann::json glb_description(std::string_view bytes);

}  // namespace silvafit::tree
