// SPDX-License-Identifier: MIT
#include "files/gltf_materials.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "files/palette.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::tree {
namespace {

const Texture* picture_of(const MeshPart& part) {
  return part.uvs.empty() ? nullptr : part.texture.get();
}

std::string scale_of(const Texture& picture) {
  const std::array<std::size_t, 2> steps = texture_steps(picture);
  return fmt::format(",\"extensions\":{{\"KHR_texture_transform\":{{\"scale\":[{},{}]}}}}",
                     1.0 / static_cast<double>(steps[0]),
                     1.0 / static_cast<double>(steps[1]));
}

}  // namespace

std::size_t GltfMaterials::number_of(const ModelPart& part) {
  const auto [found, is_new] = materials_.try_emplace(part.material, materials_.size());
  if (is_new) {
    compress_pictures(*part.mesh);
    if (!materials_text_.empty()) materials_text_ += ',';
    materials_text_ += description(part);
  }
  return found->second;
}

/// Compressing takes longer than all else in a scene of shared models: both pictures of a part at
/// the same time. png_file() keeps the results.
void GltfMaterials::compress_pictures(const MeshPart& part) const {
  if (picture_of(part) == nullptr || !has_normal_map(part, is_packed_)) return;
  parallel_for(2, threads_, [&](std::size_t i) {
    png_file(i == 0 ? part.texture : part.normal_texture, is_packed_);
  });
}

std::string GltfMaterials::description(const ModelPart& part) {
  const Color& color = part.mesh->color;
  const Texture* const picture = picture_of(*part.mesh);
  // Images are numbered in this order.
  const std::string color_texture =
      picture == nullptr ? std::string()
                         : fmt::format("\"baseColorTexture\":{{\"index\":{}{}}},",
                                       texture(part.mesh->texture),
                                       is_packed_ ? scale_of(*picture) : std::string());
  const std::string normal_texture =
      !has_normal_map(*part.mesh, is_packed_)
          ? std::string()
          : fmt::format(",\"normalTexture\":{{\"index\":{}}}", texture(part.mesh->normal_texture));
  const bool is_cut_out = picture != nullptr && has_transparency(*picture);
  return fmt::format(
      "{{\"name\":{},\"pbrMetallicRoughness\":{{\"baseColorFactor\":[{},{},{},1],{}"
      "\"metallicFactor\":0,\"roughnessFactor\":0.9}}{}{}{}}}",
      json_quoted(part.material),
      // glTF's factors are at most 1; a sum of shades may exceed this by rounding.
      std::min(color[0], 1.0),
      std::min(color[1], 1.0),
      std::min(color[2], 1.0),
      color_texture,
      normal_texture,
      is_cut_out ? ",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5" : "",
      part.mesh->double_sided ? ",\"doubleSided\":true" : "");
}

/// The index of a texture, whose image is added to the buffer once.
std::size_t GltfMaterials::texture(const std::shared_ptr<const Texture>& picture) {
  const auto [found, is_new] = textures_.try_emplace(picture->name, textures_.size());
  if (is_new) {
    if (!images_text_.empty()) images_text_ += ',';
    images_text_ += fmt::format("{{\"name\":{},\"mimeType\":\"image/png\",\"bufferView\":{}}}",
                                json_quoted(picture->name),
                                buffers_.add_view(*png_file(picture, is_packed_)));
  }
  return found->second;
}

/// Every texture has its own image; all are repeated and interpolated.
std::string GltfMaterials::textures() const {
  if (textures_.empty()) return {};
  std::string text;
  for (std::size_t i = 0; i < textures_.size(); ++i) {
    text += fmt::format("{}{{\"sampler\":0,\"source\":{}}}", i > 0 ? "," : "", i);
  }
  constexpr int kLinear = 9729;
  constexpr int kLinearOfSmaller = 9987;
  return fmt::format(
      "\"textures\":[{}],\"images\":[{}],\"samplers\":[{{\"magFilter\":{},\"minFilter\":{}}}],",
      text,
      images_text_,
      kLinear,
      kLinearOfSmaller);
}

}  // namespace silvafit::tree
