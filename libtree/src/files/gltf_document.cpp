// SPDX-License-Identifier: MIT
#include "files/gltf_document.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "files/packed_view.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"

namespace silvafit::tree {
namespace {

using nlohmann::json;
using Matrix = Eigen::Matrix4d;
constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
constexpr const char* kTextureTransform = "KHR_texture_transform";
constexpr std::size_t kMostElements = std::size_t{1} << 31U;
constexpr std::size_t kLargestStride = 252;  // of glTF
/// Bytes that a scene may take in memory: a fixed number, and a multiple of the file size. Well-
/// compressed vertices grow tenfold, and some parts share them.
constexpr std::size_t kLeastAllowance = std::size_t{1} << 29U;
constexpr std::size_t kAllowancePerByte = 256;

const json& item(const json& in, const char* array, std::size_t index) {
  const auto found = in.find(array);
  if (found == in.end() || !found->is_array() || index >= found->size()) {
    refuse_gltf(fmt::format("{}[{}] does not exist", array, index));
  }
  return (*found)[index];
}

/// An integer that is required, unless there is a default.
std::size_t number(const json& in, const char* name, std::optional<std::size_t> otherwise = {}) {
  const auto found = in.find(name);
  if (found == in.end() && otherwise) return *otherwise;
  if (found == in.end() || !found->is_number_unsigned()) {
    refuse_gltf(fmt::format("{} is not a non-negative integer", name));
  }
  return found->get<std::size_t>();
}

const json* extension(const json& in, const char* name) {
  const auto all = in.find("extensions");
  if (all == in.end() || !all->is_object()) return nullptr;
  const auto found = all->find(name);
  return found == all->end() ? nullptr : &*found;
}

Matrix placed(const Eigen::Vector3d& at,
              const Eigen::Quaterniond& turn,
              const Eigen::Vector3d& size) {
  Matrix result = Matrix::Identity();
  result.topLeftCorner<3, 3>() = turn.toRotationMatrix() * size.asDiagonal();
  result.topRightCorner<3, 1>() = at;
  return result;
}

/// Whether a transformation reduces everything to a point.
bool has_no_size(const Matrix& place) { return (place.topLeftCorner<3, 3>().array() == 0.0).all(); }

Eigen::Vector3d vector(const std::array<double, 3>& numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

/// glTF has the real part last.
Eigen::Quaterniond quaternion(const std::array<double, 4>& numbers) {
  return {numbers[3], numbers[0], numbers[1], numbers[2]};
}

std::array<double, 16> by_column(const Matrix& matrix) {
  std::array<double, 16> numbers{};
  Eigen::Map<Matrix>(numbers.data()) = matrix;
  return numbers;
}

template <std::size_t N>
std::array<double, N> numbers(const json& in, const char* name, std::array<double, N> otherwise) {
  const auto found = in.find(name);
  if (found == in.end()) return otherwise;
  if (!found->is_array() || found->size() != N)
    refuse_gltf(fmt::format("{} does not have {} numbers", name, N));
  for (std::size_t i = 0; i < N; ++i) {
    if (!(*found)[i].is_number())
      refuse_gltf(std::string(name) + " contains values that are not numbers");
    otherwise[i] = (*found)[i].template get<double>();
  }
  return otherwise;
}

/// The values of an accessor, as doubles, with as many per row as its type has.
struct Values {
  std::size_t width = 1;
  std::vector<double> numbers{};

  std::size_t rows() const { return numbers.size() / width; }
};

class Reader {
 public:
  Reader(json description, std::vector<std::string> buffers)
      : json_(std::move(description)), buffers_(std::move(buffers)) {
    for (const std::string& bytes : buffers_) allowance_ += kAllowancePerByte * bytes.size();
    scene_.nodes.resize(count_of("nodes"));
  }

  ReadScene read() {
    check_extensions();
    const json& scene = item(json_, "scenes", number(json_, "scene", 0));
    read_origin(scene);
    const std::size_t meshes = count_of("meshes");
    for (std::size_t i = 0; i < meshes; ++i)
      scene_.models.push_back(model(item(json_, "meshes", i)));
    check_hierarchy(scene);
    for (const json& root : children_of(scene, "nodes"))
      add_node(index_of(root), Matrix::Identity(), 0);
    return std::move(scene_);
  }

 private:
  std::size_t count_of(const char* array) const {
    const auto found = json_.find(array);
    return found != json_.end() && found->is_array() ? found->size() : 0;
  }

  static std::size_t index_of(const json& value) {
    if (!value.is_number_unsigned()) refuse_gltf("a reference is not an integer");
    return value.get<std::size_t>();
  }

  void check_extensions() const {
    const auto required = json_.find("extensionsRequired");
    if (required == json_.end()) return;
    for (const json& name : *required) {
      if (name != kMeshopt && name != kInstancing && name != kTextureTransform &&
          name != "KHR_mesh_quantization") {
        refuse_gltf("it requires the unsupported extension " + json_text(name));
      }
    }
  }

  static const json& children_of(const json& owner, const char* list) {
    static const json kNone = json::array();
    const auto found = owner.find(list);
    return found == owner.end() ? kNone : *found;
  }

  /// Nodes form trees, also those that are not in the scene, so that every traversal terminates.
  void check_hierarchy(const json& scene) const {
    std::vector<bool> has_parent(scene_.nodes.size(), false);
    const auto check = [&](const json& children) {
      for (const json& child : children) {
        const std::size_t index = index_of(child);
        item(json_, "nodes", index);
        if (has_parent[index]) {
          refuse_gltf(fmt::format("nodes[{}] has two parents, or is its own descendant", index));
        }
        has_parent[index] = true;
      }
    };
    for (const json& node : children_of(json_, "nodes")) check(children_of(node, "children"));
    check(children_of(scene, "nodes"));
  }

  void read_origin(const json& scene) {
    const auto extras = scene.find("extras");
    if (extras == scene.end() || !extras->contains("origin")) return;
    const json& origin = (*extras)["origin"];
    scene_.origin = {origin.value("x", 0.0), origin.value("y", 0.0), origin.value("z", 0.0)};
  }

  std::string_view slice(std::size_t buffer, std::size_t from, std::size_t size) const {
    if (buffer >= buffers_.size()) refuse_gltf(fmt::format("buffer {} does not exist", buffer));
    const std::string& bytes = buffers_[buffer];
    if (from > bytes.size() || size > bytes.size() - from)
      refuse_gltf("a buffer view exceeds its buffer");
    return std::string_view(bytes).substr(from, size);
  }

  /// The bytes of a view, decompressed if necessary, only once.
  std::string_view view(std::size_t index) {
    const json& view = item(json_, "bufferViews", index);
    const json* packed = extension(view, kMeshopt);
    if (packed == nullptr) {
      return slice(
          number(view, "buffer"), number(view, "byteOffset", 0), number(view, "byteLength"));
    }
    const auto known = unpacked_.find(index);
    if (known != unpacked_.end()) return known->second;
    return unpacked_.emplace(index, unpack(*packed)).first->second;
  }

  std::string unpack(const json& packed) {
    const std::string_view source = slice(
        number(packed, "buffer"), number(packed, "byteOffset", 0), number(packed, "byteLength"));
    const PackedView view{.mode = gltf_text(packed, "mode"),
                          .filter = gltf_text(packed, "filter"),
                          .count = number(packed, "count"),
                          .stride = number(packed, "byteStride")};
    spend(unpacked_size(view, source));
    return unpacked(view, source);
  }

  /// Counts the memory for the file's data: small files may refer to the same bytes many times.
  void spend(std::size_t bytes) {
    if (bytes > allowance_)
      refuse_gltf("its data would need too much memory because accessors share bytes too often");
    allowance_ -= bytes;
  }

  static double component(const char* at, std::size_t type, bool normalized) {
    const auto read = [at](auto value) {
      std::memcpy(&value, at, sizeof(value));
      return static_cast<double>(value);
    };
    switch (type) {
      case 5120: {
        const double value = read(std::int8_t{});
        return normalized ? std::max(value / 127.0, -1.0) : value;
      }
      case 5121:
        return read(std::uint8_t{}) / (normalized ? 255.0 : 1.0);
      case 5122: {
        const double value = read(std::int16_t{});
        return normalized ? std::max(value / 32767.0, -1.0) : value;
      }
      case 5123:
        return read(std::uint16_t{}) / (normalized ? 65535.0 : 1.0);
      case 5125:
        return read(std::uint32_t{});
      default:
        return read(float{});
    }
  }

  Values values(std::size_t index) {
    const json& accessor = item(json_, "accessors", index);
    if (accessor.contains("sparse")) refuse_gltf("sparse accessors are not supported");
    const std::size_t type = number(accessor, "componentType");
    const std::size_t size = component_size(type);
    if (size == 0) refuse_gltf(fmt::format("unknown component type {}", type));
    const std::string shape = gltf_text(accessor, "type");
    Values result{.width = component_count(shape)};
    if (result.width == 0) refuse_gltf("unknown accessor type " + shape);
    const std::size_t count = number(accessor, "count");
    const std::size_t view_index = number(accessor, "bufferView");
    const json& view_json = item(json_, "bufferViews", view_index);
    const std::size_t row = size * result.width;
    const std::size_t stride = number(view_json, "byteStride", row);
    const std::string_view bytes = view(view_index);
    const std::size_t from = number(accessor, "byteOffset", 0);
    if (stride < row || stride > kLargestStride) {
      refuse_gltf(
          fmt::format("accessor {} has a buffer view with the invalid stride {}", index, stride));
    }
    if (count > kMostElements || !has_rows(bytes.size(), from, row, stride, count)) {
      refuse_gltf(fmt::format("accessor {} exceeds its buffer view", index));
    }
    spend(count * result.width * sizeof(double));
    const bool normalized = accessor.value("normalized", false);
    result.numbers.reserve(count * result.width);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < result.width; ++k) {
        const double value =
            component(bytes.data() + from + i * stride + k * size, type, normalized);
        if (!std::isfinite(value))
          refuse_gltf(fmt::format("accessor {} has values that are not finite", index));
        result.numbers.push_back(value);
      }
    }
    return result;
  }

  ReadModel model(const json& mesh) {
    ReadModel model{.name = gltf_text(mesh, "name")};
    const std::size_t count = mesh.contains("primitives") ? mesh["primitives"].size() : 0;
    for (std::size_t i = 0; i < count; ++i) {
      model.parts.push_back(part(item(mesh, "primitives", i)));
    }
    return model;
  }

  std::vector<float> attribute(const json& attributes,
                               const char* name,
                               std::size_t width,
                               std::size_t rows) {
    if (!attributes.contains(name)) return {};
    const Values read = values(number(attributes, name));
    if (read.width != width || (rows > 0 && read.rows() != rows)) {
      refuse_gltf(fmt::format("{} and POSITION differ in length", name));
    }
    return {read.numbers.begin(), read.numbers.end()};
  }

  ReadPart part(const json& primitive) {
    if (number(primitive, "mode", 4) != 4) refuse_gltf("only triangles are supported");
    const auto found = primitive.find("attributes");
    if (found == primitive.end()) refuse_gltf("a primitive has no attributes");
    const json& attributes = *found;
    ReadPart part;
    if (primitive.contains("extras")) part.part = gltf_text(primitive["extras"], "part");
    part.mesh.kind = PartKind::kStem;
    for (const PartKind kind : {PartKind::kBranches, PartKind::kFoliage, PartKind::kAerialRoots}) {
      if (part.part == part_name(kind)) part.mesh.kind = kind;
    }
    if (primitive.contains("material")) read_material(number(primitive, "material"), part);
    part.mesh.positions = attribute(attributes, "POSITION", 3, 0);
    const std::size_t rows = part.mesh.vertex_count();
    if (rows == 0) refuse_gltf("a primitive has no positions");
    part.mesh.normals = attribute(attributes, "NORMAL", 3, rows);
    part.mesh.uvs = attribute(attributes, "TEXCOORD_0", 2, rows);
    if (primitive.contains("material")) {
      transform_uvs(item(json_, "materials", number(primitive, "material")), part.mesh.uvs);
    }
    part.mesh.tangents = attribute(attributes, "TANGENT", 4, rows);
    for (const float value : attribute(attributes, "COLOR_0", 4, rows)) {
      part.mesh.colors.push_back(
          static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(value, 0.0F, 1.0F))));
    }
    read_indices(primitive, part.mesh);
    return part;
  }

  void read_material(std::size_t index, ReadPart& part) {
    const json& material = item(json_, "materials", index);
    part.material = gltf_text(material, "name");
    spend(part.material.size());
    part.mesh.double_sided = material.value("doubleSided", false);
    part.mesh.normal_texture = texture_of(material, "normalTexture");
    if (!material.contains("pbrMetallicRoughness")) return;
    const json& base = material["pbrMetallicRoughness"];
    const auto color = numbers<4>(base, "baseColorFactor", {1, 1, 1, 1});
    part.mesh.color = {color[0], color[1], color[2]};
    part.mesh.texture = texture_of(base, "baseColorTexture");
  }

  /// KHR_texture_transform of the picture of the color, which holds for the normals, too.
  static void transform_uvs(const json& material, std::vector<float>& uvs) {
    const json::json_pointer place("/pbrMetallicRoughness/baseColorTexture/extensions");
    if (!material.contains(place) || !material.at(place).contains(kTextureTransform)) return;
    const json& transform = material.at(place)[kTextureTransform];
    const auto offset = numbers<2>(transform, "offset", {0, 0});
    const auto scale = numbers<2>(transform, "scale", {1, 1});
    const auto turn = transform.find("rotation");
    const double rotation =
        turn != transform.end() && turn->is_number() ? turn->get<double>() : 0.0;
    const double sine = std::sin(rotation);
    const double cosine = std::cos(rotation);
    for (std::size_t i = 0; i + 1 < uvs.size(); i += 2) {
      const double u = scale[0] * double{uvs[i]};
      const double v = scale[1] * double{uvs[i + 1]};
      uvs[i] = static_cast<float>(cosine * u + sine * v + offset[0]);
      uvs[i + 1] = static_cast<float>(cosine * v - sine * u + offset[1]);
    }
  }

  std::shared_ptr<const Texture> texture_of(const json& material, const char* name) {
    if (!material.contains(name)) return nullptr;
    const json& texture = item(json_, "textures", number(material[name], "index"));
    return texture.contains("source") ? picture(number(texture, "source")) : nullptr;
  }

  /// A PNG image in a buffer; null for other formats.
  std::shared_ptr<const Texture> picture(std::size_t index) {
    const auto known = pictures_.find(index);
    if (known != pictures_.end()) return known->second;
    const json& image = item(json_, "images", index);
    std::shared_ptr<const Texture> texture;
    const std::string uri = gltf_text(image, "uri");
    if (!uri.empty() && !uri.starts_with("data:")) {
      throw InputError("the scene needs the picture " + uri +
                       " in a file of its own, which is not read; export the scene as one GLB file "
                       "that contains its pictures");
    }
    if (image.contains("bufferView") && gltf_text(image, "mimeType") == "image/png") {
      std::string name = gltf_text(image, "name");
      if (name.empty()) name = fmt::format("image-{}", index);
      texture = std::make_shared<const Texture>(
          texture_from_png(view(number(image, "bufferView")), std::move(name)));
      spend(texture->rgba.size());
    }
    return pictures_.emplace(index, std::move(texture)).first->second;
  }

  void read_indices(const json& primitive, MeshPart& mesh) {
    if (!primitive.contains("indices")) {
      for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) mesh.indices.push_back(i);
    } else {
      for (const double value : values(number(primitive, "indices")).numbers) {
        if (value < 0.0 || value >= static_cast<double>(mesh.vertex_count())) {
          refuse_gltf("a vertex index is too large");
        }
        mesh.indices.push_back(static_cast<std::uint32_t>(value));
      }
    }
    if (mesh.indices.size() % 3 != 0) refuse_gltf("the number of indices is not a multiple of 3");
  }

  /// \returns whether it is shown
  bool add_node(std::size_t index, const Matrix& parent, int depth) {
    constexpr int kDeepest = 64;
    if (depth > kDeepest) refuse_gltf("its nodes are nested too deeply");
    const json& node = item(json_, "nodes", index);
    Matrix own = parent;
    if (node.contains("matrix")) {
      own *= Eigen::Map<const Matrix>(numbers<16>(node, "matrix", {}).data());
    } else {
      own *= placed(vector(numbers<3>(node, "translation", {0, 0, 0})),
                    quaternion(numbers<4>(node, "rotation", {0, 0, 0, 1})),
                    vector(numbers<3>(node, "scale", {1, 1, 1})));
    }
    ReadNode& read = scene_.nodes[index];
    read = {.name = gltf_text(node, "name"), .transform = by_column(own)};
    spend(read.name.size());
    // Nodes that an animation shows at another time now have scale 0.
    if (has_no_size(own)) return false;
    if (node.contains("mesh")) {
      const std::size_t mesh = number(node, "mesh");
      if (mesh >= scene_.models.size()) refuse_gltf(fmt::format("meshes[{}] does not exist", mesh));
      add_instances(node, mesh, own);
    }
    read.is_shown = node.contains("mesh");
    for (const json& child : children_of(node, "children")) {
      if (add_node(index_of(child), own, depth + 1)) read.is_shown = true;
    }
    return read.is_shown;
  }

  void add_instances(const json& node, std::size_t mesh, const Matrix& own) {
    const json* instancing = extension(node, kInstancing);
    if (instancing == nullptr) {
      add_instance({gltf_text(node, "name"), mesh, by_column(own)});
      return;
    }
    const auto found = instancing->find("attributes");
    if (found == instancing->end()) refuse_gltf("instances have no attributes");
    const auto column = [&](const char* name, std::size_t width) -> Values {
      if (!found->contains(name)) return {.width = width};
      Values read = values(number(*found, name));
      if (read.width != width) refuse_gltf(fmt::format("instances have an invalid {}", name));
      return read;
    };
    const Values translation = column("TRANSLATION", 3);
    const Values rotation = column("ROTATION", 4);
    const Values scale = column("SCALE", 3);
    const Values tree = column("_TREE", 1);
    const std::size_t count =
        std::max({translation.rows(), rotation.rows(), scale.rows(), tree.rows()});
    for (const Values* values : {&translation, &rotation, &scale, &tree}) {
      if (values->rows() != 0 && values->rows() != count)
        refuse_gltf("the attributes of instances differ in length");
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto row = [i](const Values& from, auto otherwise) {
        for (std::size_t k = 0; k < otherwise.size() && from.rows() > 0; ++k) {
          otherwise[k] = from.numbers[i * from.width + k];
        }
        return otherwise;
      };
      const Matrix there =
          own * placed(vector(row(translation, std::array<double, 3>{0, 0, 0})),
                       quaternion(row(rotation, std::array<double, 4>{0, 0, 0, 1})),
                       vector(row(scale, std::array<double, 3>{1, 1, 1})));
      if (has_no_size(there)) continue;
      add_instance({gltf_text(node, "name"),
                    mesh,
                    by_column(there),
                    tree.rows() > 0 ? tree.numbers[i] : -1.0});
    }
  }

  void add_instance(ReadInstance instance) {
    constexpr double kMost = std::numeric_limits<float>::max();
    for (const double value : instance.transform) {
      if (!(std::abs(value) <= kMost))
        refuse_gltf("the position of a node is too far from the origin");
    }
    spend(instance.name.size() + sizeof(instance));
    scene_.instances.push_back(std::move(instance));
  }

  json json_;
  std::vector<std::string> buffers_;
  std::size_t allowance_ = kLeastAllowance;
  std::map<std::size_t, std::string> unpacked_{};
  std::map<std::size_t, std::shared_ptr<const Texture>> pictures_{};
  ReadScene scene_{};
};

}  // namespace

void refuse_gltf(const std::string& what) {
  throw InputError("cannot read the glTF scene: " + what);
}

std::string gltf_text(const json& in, const char* name) {
  const auto found = in.find(name);
  return found != in.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::size_t component_size(std::size_t type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

std::size_t component_count(std::string_view type) {
  constexpr std::array<std::string_view, 5> kTypes{"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  const auto found = std::ranges::find(kTypes, type);
  return found == kTypes.end() ? 0 : static_cast<std::size_t>(found - kTypes.begin());
}

bool has_rows(
    std::size_t bytes, std::size_t from, std::size_t row, std::size_t stride, std::size_t count) {
  // A division instead of a multiplication, because the product of two numbers of the file may
  // overflow.
  return count > 0 && stride >= row && from <= bytes && row <= bytes - from &&
         count - 1 <= (bytes - from - row) / stride;
}

ReadScene read_document(json description, std::vector<std::string> buffers) {
  return Reader(std::move(description), std::move(buffers)).read();
}

}  // namespace silvafit::tree
