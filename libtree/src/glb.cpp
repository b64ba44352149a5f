// SPDX-License-Identifier: MIT
// The one file that knows tinygltf; its implementation is compiled into Debian's library.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#include <tiny_gltf.h>
#pragma GCC diagnostic pop

#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>
#include <string>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/scene.hpp"

namespace silvafit::tree {
namespace {

tinygltf::Value number(double value) { return tinygltf::Value(value); }
tinygltf::Value text(const std::string& value) { return tinygltf::Value(value); }

tinygltf::Value radii_value(const CrownRadii& radii) {
  return tinygltf::Value(tinygltf::Value::Object{{"e", number(radii.east_m)},
                                                 {"w", number(radii.west_m)},
                                                 {"s", number(radii.south_m)},
                                                 {"n", number(radii.north_m)}});
}

tinygltf::Value extras_of(const SceneTree& tree) {
  tinygltf::Value::Array notes;
  for (const Note& note : tree.notes) notes.push_back(text(note.about + ": " + note.text));
  tinygltf::Value::Object extras{{"plot", text(tree.plot)},
                                 {"tree", text(tree.tree)},
                                 {"species", text(tree.species)},
                                 {"preset", text(tree.preset)},
                                 {"h", number(tree.measured.h_m)},
                                 {"hcb", number(tree.measured.hcb_m)},
                                 {"dbh", number(tree.measured.dbh_cm)},
                                 {"cw", number(tree.measured.radii.width_m())},
                                 {"radii", radii_value(tree.measured.radii)}};
  if (!notes.empty()) extras["notes"] = tinygltf::Value(notes);
  return tinygltf::Value(extras);
}

/// Two bytes an index where they suffice; the largest value of each type is reserved.
bool has_narrow_indices(std::size_t vertices) {
  return vertices < std::numeric_limits<std::uint16_t>::max();
}

void write_model(const tinygltf::Model& model, std::ostream& stream) {
  tinygltf::TinyGLTF writer;
  constexpr bool kPretty = false;
  constexpr bool kBinary = true;
  if (!writer.WriteGltfSceneToStream(&model, stream, kPretty, kBinary)) {
    throw GeometryError("the scene cannot be written as GLB");
  }
}

/// The format aligns to four bytes.
std::size_t aligned(std::size_t size) { return (size + 3) / 4 * 4; }

/// Collects buffers, accessors, meshes and nodes of a scene.
class GltfBuilder {
 public:
  /// \throws GeometryError if the scene's trees are none or too many
  explicit GltfBuilder(const Scene& scene) : origin_(scene.origin) {
    model_.asset.version = "2.0";
    model_.asset.generator = "silvafit";
    model_.buffers.resize(1);
    model_.buffers[0].data.reserve(expected_size(scene));
    model_.scenes.resize(1);
    model_.defaultScene = 0;
    describe_frame();
  }

  void add_tree(const SceneTree& tree) {
    tinygltf::Mesh mesh;
    mesh.name = tree.name();
    for (const MeshPart& part : tree.mesh.parts) mesh.primitives.push_back(primitive(part, tree));
    tinygltf::Node node;
    node.name = tree.name();
    node.mesh = static_cast<int>(model_.meshes.size());
    node.extras = extras_of(tree);
    const double east = tree.position.x_m - origin_.x_m;
    const double north = tree.position.y_m - origin_.y_m;
    node.translation = {east, tree.position.z_m - origin_.z_m, 0.0 - north};
    model_.meshes.push_back(std::move(mesh));
    model_.scenes[0].nodes.push_back(static_cast<int>(model_.nodes.size()));
    model_.nodes.push_back(std::move(node));
  }

  const tinygltf::Model& model() const { return model_; }

 private:
  static std::size_t expected_size(const Scene& scene) {
    if (scene.trees.empty()) throw GeometryError("a scene needs at least one tree");
    std::size_t size = 0;
    for (const SceneTree& tree : scene.trees) size += glb_mesh_bytes(tree.mesh);
    if (size > std::numeric_limits<std::uint32_t>::max() / 2) {
      throw GeometryError(
          "the scene is larger than a GLB file can be; write one file a tree, or fewer plots");
    }
    return size;
  }

  /// Where the scene lies in the inventory.
  void describe_frame() {
    model_.scenes[0].extras = tinygltf::Value(tinygltf::Value::Object{
        {"origin",
         tinygltf::Value(tinygltf::Value::Object{{"x", number(origin_.x_m)},
                                                 {"y", number(origin_.y_m)},
                                                 {"z", number(origin_.z_m)}})}});
  }

  tinygltf::Primitive primitive(const MeshPart& part, const SceneTree& tree) {
    tinygltf::Primitive result;
    result.mode = TINYGLTF_MODE_TRIANGLES;
    result.material = material(part, tree.preset);
    const auto vertices = part.vertex_count();
    const int positions = floats(part.positions, vertices);
    set_bounds(model_.accessors[static_cast<std::size_t>(positions)], part.positions);
    result.attributes["POSITION"] = positions;
    result.attributes["NORMAL"] = floats(part.normals, vertices);
    if (!part.colors.empty()) result.attributes["COLOR_0"] = colors(part.colors, vertices);
    result.indices = indices(part.indices, vertices);
    return result;
  }

  int floats(const std::vector<float>& values, std::size_t vertices) {
    return accessor(values.data(),
                    values.size() * sizeof(float),
                    vertices,
                    TINYGLTF_COMPONENT_TYPE_FLOAT,
                    TINYGLTF_TYPE_VEC3,
                    TINYGLTF_TARGET_ARRAY_BUFFER);
  }

  int colors(const std::vector<std::uint8_t>& values, std::size_t vertices) {
    const int index = accessor(values.data(),
                               values.size(),
                               vertices,
                               TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE,
                               TINYGLTF_TYPE_VEC4,
                               TINYGLTF_TARGET_ARRAY_BUFFER);
    model_.accessors[static_cast<std::size_t>(index)].normalized = true;
    return index;
  }

  int indices(const std::vector<std::uint32_t>& values, std::size_t vertices) {
    if (!has_narrow_indices(vertices)) {
      return accessor(values.data(),
                      values.size() * sizeof(std::uint32_t),
                      values.size(),
                      TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                      TINYGLTF_TYPE_SCALAR,
                      TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    }
    const std::vector<std::uint16_t> narrow(values.begin(), values.end());
    return accessor(narrow.data(),
                    narrow.size() * sizeof(std::uint16_t),
                    values.size(),
                    TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                    TINYGLTF_TYPE_SCALAR,
                    TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  }

  /// Appends bytes to the buffer as one view with one accessor.
  int accessor(
      const void* data, std::size_t size, std::size_t count, int component, int type, int target) {
    std::vector<unsigned char>& buffer = model_.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer.size();
    view.byteLength = size;
    view.target = target;
    const auto* bytes = static_cast<const unsigned char*>(data);
    buffer.insert(buffer.end(), bytes, bytes + size);
    buffer.resize(aligned(buffer.size()), 0);

    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size());
    accessor.componentType = component;
    accessor.count = count;
    accessor.type = type;
    model_.bufferViews.push_back(std::move(view));
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size() - 1);
  }

  static void set_bounds(tinygltf::Accessor& accessor, const std::vector<float>& positions) {
    accessor.minValues.assign(positions.begin(), positions.begin() + 3);
    accessor.maxValues = accessor.minValues;
    for (std::size_t i = 3; i < positions.size(); ++i) {
      const double value = positions[i];
      accessor.minValues[i % 3] = std::min(accessor.minValues[i % 3], value);
      accessor.maxValues[i % 3] = std::max(accessor.maxValues[i % 3], value);
    }
  }

  /// One material for each preset and kind of part.
  int material(const MeshPart& part, const std::string& preset) {
    const std::string name = preset + "-" + part_name(part.kind);
    const auto [found, is_new] =
        materials_.try_emplace(name, static_cast<int>(model_.materials.size()));
    if (is_new) {
      tinygltf::Material material;
      material.name = name;
      material.doubleSided = part.double_sided;
      material.pbrMetallicRoughness.baseColorFactor = {
          part.color[0], part.color[1], part.color[2], 1.0};
      material.pbrMetallicRoughness.metallicFactor = 0.0;
      material.pbrMetallicRoughness.roughnessFactor = 0.9;
      model_.materials.push_back(std::move(material));
    }
    return found->second;
  }

  Position origin_;
  tinygltf::Model model_;
  std::map<std::string, int> materials_;
};

}  // namespace

std::size_t glb_mesh_bytes(const Mesh& mesh) {
  std::size_t size = 0;
  for (const MeshPart& part : mesh.parts) {
    const std::size_t index_size = has_narrow_indices(part.vertex_count()) ? 2 : 4;
    size += sizeof(float) * (part.positions.size() + part.normals.size()) + part.colors.size() +
            aligned(index_size * part.indices.size());
  }
  return size;
}

std::string glb_bytes(const Scene& scene) {
  GltfBuilder builder(scene);
  for (const SceneTree& tree : scene.trees) builder.add_tree(tree);
  std::ostringstream stream;
  write_model(builder.model(), stream);
  return std::move(stream).str();
}

void write_glb(Scene scene, const std::filesystem::path& path) {
  GltfBuilder builder(scene);
  for (SceneTree& tree : scene.trees) {
    builder.add_tree(tree);
    tree.mesh = {};
  }
  AtomicFile file(path);
  write_model(builder.model(), file.stream());
  file.commit();
}

}  // namespace silvafit::tree
