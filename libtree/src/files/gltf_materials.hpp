// SPDX-License-Identifier: MIT
// Materials of a glTF file and their textures.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>

#include "files/gltf_buffers.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {

/// Materials and images by name, each written once.
class GltfMaterials {
 public:
  /// \param buffers  receive the bytes of the images; must outlive this
  /// \param is_packed  quantized or compressed
  /// \param threads    of parallel_for()
  GltfMaterials(GltfBuffers& buffers, bool is_packed, unsigned threads)
      : buffers_(buffers), is_packed_(is_packed), threads_(threads) {}

  /// The index of a part's material: that of the first part with the same material name.
  std::size_t number_of(const ModelPart& part);

  /// The items of the array "materials".
  const std::string& materials() const { return materials_text_; }
  /// The fields "textures", "images" and "samplers", each followed by a comma; nothing without
  /// images.
  std::string textures() const;
  bool has_textures() const { return !textures_.empty(); }

 private:
  void compress_pictures(const MeshPart& part) const;
  std::string description(const ModelPart& part);
  std::size_t texture(const std::shared_ptr<const Texture>& picture);

  GltfBuffers& buffers_;
  bool is_packed_;
  unsigned threads_;
  std::map<std::string, std::size_t> materials_{};
  std::string materials_text_{};
  std::map<std::string, std::size_t> textures_{};
  std::string images_text_{};
};

}  // namespace silvafit::tree
