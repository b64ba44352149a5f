// SPDX-License-Identifier: MIT
// Models for formats without shared meshes: every instance gets its own vertices.
#pragma once

#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {

/// Scales and moves the vertices of a part, and transforms its normals.
inline MeshPart baked(const MeshPart& part, const Placement& placement, const Position& origin) {
  MeshPart result = part;
  const double stretch[3] = {placement.stretch_east, placement.stretch_up, placement.stretch_north};
  const double shift[3] = {placement.position.x_m - origin.x_m,
                           placement.position.z_m - origin.z_m,
                           -(placement.position.y_m - origin.y_m)};
  for (std::size_t i = 0; i < result.positions.size(); ++i) {
    result.positions[i] =
        static_cast<float>(stretch[i % 3] * double{part.positions[i]} + shift[i % 3]) + 0.0F;
  }
  for (std::size_t i = 0; i + 2 < result.normals.size(); i += 3) {
    // Normals are multiplied by the inverse scale.
    const Point normal = direction({part.normals[i] / stretch[0],
                                    part.normals[i + 1] / stretch[1],
                                    part.normals[i + 2] / stretch[2]});
    result.normals[i] = static_cast<float>(normal.x);
    result.normals[i + 1] = static_cast<float>(normal.y);
    result.normals[i + 2] = static_cast<float>(normal.z);
  }
  return result;
}

/// Stores copies of models until they are placed.
class BakingWriter : public SceneWriter {
 public:
  explicit BakingWriter(const Position& origin) : origin_(origin) {}

  Model add_model(const std::string& name, const std::vector<ModelPart>& parts) override {
    std::vector<KeptPart> kept;
    for (const ModelPart& part : parts) {
      if (!part.mesh->indices.empty()) kept.push_back({part.part, part.material, *part.mesh});
    }
    if (kept.empty()) throw GeometryError("the model " + name + " has no triangles");
    models_.push_back(std::move(kept));
    return models_.size() - 1;
  }

  void place(Model model,
             const std::string& name,
             const Placement& placement,
             std::size_t /*number*/) override {
    begin_tree(name);
    for (const KeptPart& part : models_[model]) {
      add_part(part.part, part.material, baked(part.mesh, placement, origin_));
    }
  }

  void add_tree(const SceneTree& tree) override {
    begin_tree(tree.name());
    for (const ModelPart& part : parts_of(tree.mesh, tree.preset)) {
      add_part(part.part, part.material, baked(*part.mesh, {.position = tree.position}, origin_));
    }
  }

 protected:
  virtual void begin_tree(const std::string& name) = 0;
  virtual void add_part(const std::string& part,
                        const std::string& material,
                        const MeshPart& mesh) = 0;

 private:
  struct KeptPart {
    std::string part{};
    std::string material{};
    MeshPart mesh{};
  };
  Position origin_;
  std::vector<std::vector<KeptPart>> models_{};
};

}  // namespace silvafit::tree
