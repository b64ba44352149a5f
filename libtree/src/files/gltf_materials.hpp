// SPDX-License-Identifier: MIT
// Materials of a glTF file and the pictures on them.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "files/gltf_buffers.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {

/// Materials by their names and pictures by theirs, each written once.
class GltfMaterials {
 public:
  /// \param buffers  take the pictures' bytes; they must outlive this
  explicit GltfMaterials(GltfBuffers& buffers) : buffers_(buffers) {}

  /// The number of a part's material, which is that of the first part of the material's name.
  std::size_t number_of(const ModelPart& part);

  /// The items of the array "materials".
  const std::string& materials() const { return materials_text_; }
  /// The fields "textures", "images" and "samplers", each with a comma after it; nothing without
  /// pictures.
  std::string textures() const;

 private:
  std::string description(const ModelPart& part);
  std::size_t texture(const Texture& picture);

  GltfBuffers& buffers_;
  std::map<std::string, std::size_t> materials_{};
  std::string materials_text_{};
  std::map<std::string, std::size_t> textures_{};
  std::string images_text_{};
};

}  // namespace silvafit::tree
