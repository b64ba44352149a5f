// SPDX-License-Identifier: MIT
#include "silvafit/tree/scene_writer.hpp"

#include <utility>

#include "files/format_writers.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {

SceneFormat scene_format_from_text(const std::string& text) {
  if (text == "glb") return SceneFormat::kGlb;
  if (text == "gltf") return SceneFormat::kGltf;
  if (text == "obj") return SceneFormat::kObj;
  if (text == "ply") return SceneFormat::kPly;
  throw UsageError("a scene format must be glb, gltf, obj or ply, not " + text);
}

const char* file_ending(SceneFormat format) {
  switch (format) {
    case SceneFormat::kGlb:
      return "glb";
    case SceneFormat::kGltf:
      return "gltf";
    case SceneFormat::kObj:
      return "obj";
    case SceneFormat::kPly:
      return "ply";
  }
  return "";
}

std::vector<ModelPart> parts_of(const Mesh& mesh, const std::string& preset) {
  std::vector<ModelPart> parts;
  for (const MeshPart& part : mesh.parts) {
    std::string material = preset + "-";
    if (!part.variant.empty()) material += part.variant + "-";
    material += material_name(material_of(part.kind));
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
