// SPDX-License-Identifier: MIT
#include "silvafit/render/models.hpp"

#include "silvafit/base/error.hpp"

namespace silvafit::render {
namespace {

Material material_of(const tree::ReadPart& part) {
  const tree::MeshPart& mesh = part.mesh;
  Material material{.color = {mesh.color[0], mesh.color[1], mesh.color[2]},
                    .double_sided = mesh.double_sided};
  // Light that passes thin leaves relative to the light that they scatter back: a leaf is
  // assumed to transmit about as much as it reflects, and shoots have several leaves behind each
  // other. The Fresnel reflectance of wax (n = 1.4), and the
  // roughness of its surface (Bousquet et al. 2005, 0.3 to 0.5).
  constexpr double kLeafTranslucency = 0.6;
  constexpr double kLeafReflectance = 0.028;
  constexpr double kLeafRoughness = 0.5;
  // silvafit names materials after presets, such as generic-conifer-leaf. Names in other files are
  // unknown.
  const bool is_ours = !part.part.empty();
  const bool is_leaf = is_ours
                           ? part.material.ends_with(tree::material_name(tree::PartKind::kFoliage))
                           : mesh.double_sided;
  if (is_leaf) {
    material.translucency = kLeafTranslucency;
    material.reflectance = kLeafReflectance;
    material.roughness = kLeafRoughness;
  }
  return material;
}

}  // namespace

Scene scene_of(const tree::ReadScene& read) {
  if (read.triangle_count() == 0) {
    throw InputError("nothing to draw: the file has no triangles", {.file = read.file});
  }
  Scene scene;
  for (const tree::ReadModel& model : read.models) {
    Model& target = scene.models.emplace_back();
    for (const tree::ReadPart& part : model.parts) {
      target.surfaces.push_back({.material = material_of(part),
                                 .positions = part.mesh.positions,
                                 .normals = part.mesh.normals,
                                 .colors = part.mesh.colors,
                                 .indices = part.mesh.indices,
                                 .uvs = part.mesh.uvs,
                                 .texture = part.mesh.texture,
                                 .normal_texture = part.mesh.normal_texture,
                                 .is_ground = part.part == "ground"});
    }
  }
  for (const tree::ReadInstance& instance : read.instances) {
    scene.instances.push_back({.model = instance.model, .transform = instance.transform});
    if (tree::is_flattened(instance.transform)) {
      throw InputError("the node '" + instance.name + "' is scaled to 0 in one direction",
                       {.file = read.file});
    }
  }
  return scene;
}

}  // namespace silvafit::render
