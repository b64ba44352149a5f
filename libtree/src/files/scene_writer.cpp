// SPDX-License-Identifier: MIT
#include "silvafit/tree/scene_writer.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "files/format_writers.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {

std::vector<ModelPart> parts_of(const Mesh& mesh, const std::string& preset) {
  std::vector<ModelPart> parts;
  for (const MeshPart& part : mesh.parts) {
    std::string material = preset + "-";
    if (!part.variant.empty()) material += part.variant + "-";
    material += material_name(part.kind);
    parts.push_back({.part = part_name(part.kind), .material = std::move(material), .mesh = &part});
  }
  return parts;
}

void SceneWriter::animate(const std::string&,
                          const Position&,
                          const std::vector<AnimatedModel>&,
                          const std::string&) {
  throw UsageError("animations need the format glb or gltf");
}

std::unique_ptr<SceneWriter> open_scene(const std::filesystem::path& path,
                                        SceneFormat format,
                                        const SceneOptions& options) {
  const bool is_gltf = format == SceneFormat::kGlb || format == SceneFormat::kGltf;
  if (!is_gltf && (options.instancing || options.quantize || options.compress)) {
    throw UsageError("instancing, quantization and compression need the format glb or gltf");
  }
  if (options.ascii && format != SceneFormat::kPly) {
    throw UsageError("only ply can be written as text");
  }
  if (is_gltf) return make_gltf_writer(path, format == SceneFormat::kGlb, options);
  return format == SceneFormat::kObj ? make_obj_writer(path, options)
                                     : make_ply_writer(path, options);
}

}  // namespace silvafit::tree
