// SPDX-License-Identifier: MIT
#include "silvafit/tree/packed_glb.hpp"

#include <meshoptimizer.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "files/glb_container.hpp"
#include "files/gltf_buffers.hpp"
#include "files/gltf_document.hpp"
#include "files/packed_part.hpp"
#include "files/packed_rows.hpp"
#include "silvafit/base/json_text.hpp"

namespace silvafit::tree {
namespace {

using nlohmann::json;
constexpr const char* kCompressionName = "EXT_meshopt_compression";
constexpr const char* kQuantizationName = "KHR_mesh_quantization";
constexpr int kTriangles = 4;
/// Uncompressed bytes that share views.
constexpr std::size_t kBytesTogether = std::size_t{1} << 18U;

/// How the values of an accessor are used, and therefore compressed.
enum class Role { kNone, kPosition, kNormal, kTangent, kUv, kOther, kIndices, kKept };

/// Rows of one format share a view.
struct Format {
  std::string mode{};
  std::string filter{};
  std::size_t stride = 0;

  auto key() const { return std::tie(mode, filter, stride); }
  bool operator<(const Format& other) const { return key() < other.key(); }
};

/// Rows that wait for compression, and the accessors of which they are.
struct Batch {
  Bytes bytes{};
  std::vector<std::pair<std::size_t, std::size_t>> starts{};  // of accessors
};

bool has_floats(const json& accessor) {
  return accessor.at("componentType").get<int>() == static_cast<int>(ComponentType::kFloat);
}

/// Least and largest position, as a reader finds them.
void set_bounds(json& accessor, const std::vector<float>& positions, int exponent) {
  std::vector<double> low(3);
  std::vector<double> high(3);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double value = from_steps(positions[i], exponent);
    low[i % 3] = i < 3 ? value : std::min(low[i % 3], value);
    high[i % 3] = i < 3 ? value : std::max(high[i % 3], value);
  }
  accessor["min"] = low;
  accessor["max"] = high;
}

/// Whether nothing but the known parts of the document refers to accessors and views.
bool has_known_references(const json& description) {
  static const std::set<std::string> kKnown{"EXT_mesh_gpu_instancing",
                                            "EXT_texture_webp",
                                            "KHR_lights_punctual",
                                            "KHR_texture_basisu",
                                            "KHR_texture_transform",
                                            kQuantizationName};
  const json used = description.value("extensionsUsed", json::array());
  return std::ranges::all_of(used, [](const json& name) {
    const auto text = name.get<std::string>();
    return kKnown.contains(text) || text.starts_with("KHR_materials_");
  });
}

class GlbPacker {
 public:
  GlbPacker(json description, std::string_view buffer)
      : json_(std::move(description)), source_(buffer) {
    roles_.resize(json_.value("accessors", json::array()).size(), Role::kNone);
    uses_.resize(roles_.size(), 0);
    is_done_.resize(roles_.size(), false);
  }

  std::string packed() {
    find_roles();
    keep_views();
    for (json& mesh : json_["meshes"]) {
      for (json& primitive : mesh["primitives"]) add_primitive(primitive);
    }
    compress_waiting();
    return assembled();
  }

 private:
  void use(const json& accessor, Role role) {
    const auto index = accessor.get<std::size_t>();
    if (index >= roles_.size()) refuse_gltf("a reference to an accessor is too large");
    Role& known = roles_[index];
    known = known == Role::kNone || known == role ? role : Role::kKept;
    ++uses_[index];
  }

  void keep_all(const json& attributes) {
    for (const json& accessor : attributes) use(accessor, Role::kKept);
  }

  static Role role_of(const std::string& attribute) {
    if (attribute == "POSITION") return Role::kPosition;
    if (attribute == "NORMAL") return Role::kNormal;
    if (attribute == "TANGENT") return Role::kTangent;
    return attribute.starts_with("TEXCOORD_") ? Role::kUv : Role::kOther;
  }

  void find_roles() {
    for (const json& mesh : json_.value("meshes", json::array())) {
      for (const json& primitive : mesh.at("primitives")) find_roles(primitive);
    }
    for (const json& skin : json_.value("skins", json::array())) {
      if (skin.contains("inverseBindMatrices")) use(skin["inverseBindMatrices"], Role::kKept);
    }
    for (const json& animation : json_.value("animations", json::array())) {
      for (const json& sampler : animation.at("samplers")) {
        use(sampler.at("input"), Role::kKept);
        use(sampler.at("output"), Role::kKept);
      }
    }
    const json::json_pointer instances("/extensions/EXT_mesh_gpu_instancing/attributes");
    for (const json& node : json_.value("nodes", json::array())) {
      if (node.contains(instances)) keep_all(node.at(instances));
    }
    for (std::size_t i = 0; i < roles_.size(); ++i) check_role(i);
  }

  void find_roles(const json& primitive) {
    const bool is_packed =
        primitive.value("mode", kTriangles) == kTriangles && !primitive.contains("targets");
    for (const auto& [name, accessor] : primitive.at("attributes").items()) {
      use(accessor, is_packed ? role_of(name) : Role::kKept);
    }
    if (primitive.contains("indices")) {
      use(primitive["indices"], is_packed ? Role::kIndices : Role::kKept);
    }
    if (primitive.contains("targets")) {
      for (const json& target : primitive["targets"]) keep_all(target);
    }
  }

  /// Values without a view of the file's own buffer, or of an unusual type, are kept.
  void check_role(std::size_t index) {
    Role& role = roles_[index];
    if (role == Role::kKept) return;
    const json& accessor = json_["accessors"][index];
    const std::size_t width = component_count(accessor.at("type").get<std::string>());
    if (role == Role::kNone || width == 0 || !accessor.contains("bufferView") ||
        view_of(accessor).at("buffer").get<std::size_t>() != 0) {
      role = Role::kKept;
      return;
    }
    const bool is_float = has_floats(accessor);
    const std::size_t expected = role == Role::kTangent ? 4 : role == Role::kUv ? 2 : 3;
    const bool is_filtered = role != Role::kOther && role != Role::kIndices;
    if (is_filtered && !(is_float && width == expected)) role = Role::kOther;
    if (role == Role::kIndices && accessor.at("count").get<std::size_t>() % 3 != 0) {
      role = Role::kKept;
    }
  }

  const json& view_of(const json& accessor) const {
    const auto index = accessor.at("bufferView").get<std::size_t>();
    const json& views = json_.at("bufferViews");
    if (index >= views.size()) refuse_gltf("a reference to a buffer view is too large");
    return views[index];
  }

  std::string_view bytes_of_view(const json& view) const {
    const auto from = view.value("byteOffset", std::size_t{0});
    const auto size = view.at("byteLength").get<std::size_t>();
    if (from > source_.size() || size > source_.size() - from) {
      refuse_gltf("a buffer view exceeds its buffer");
    }
    return source_.substr(from, size);
  }

  Rows read(std::size_t index) const {
    const json& accessor = json_["accessors"][index];
    const json& view = view_of(accessor);
    const std::string_view bytes = bytes_of_view(view);
    const std::size_t each = component_size(accessor.at("componentType")) *
                             component_count(accessor.at("type").get<std::string>());
    const auto stride = view.value("byteStride", each);
    const auto from = accessor.value("byteOffset", std::size_t{0});
    const auto count = accessor.at("count").get<std::size_t>();
    if (!has_rows(bytes.size(), from, each, stride, count)) {
      refuse_gltf("an accessor exceeds its buffer view");
    }
    Rows rows{.each = each, .bytes = Bytes(count * each)};
    for (std::size_t i = 0; i < count; ++i) {
      std::memcpy(&rows.bytes[i * each], bytes.data() + from + i * stride, each);
    }
    return rows;
  }

  /// Copies the views of pictures and of kept accessors, and numbers them anew.
  void keep_views() {
    std::map<std::size_t, std::size_t> numbers;
    const auto keep = [&](json& owner) {
      if (!owner.contains("bufferView")) return;
      const auto index = owner["bufferView"].get<std::size_t>();
      const auto [found, is_new] = numbers.emplace(index, views_.size());
      owner["bufferView"] = found->second;
      if (!is_new) return;
      json view = json_.at("bufferViews").at(index);
      if (view.at("buffer").get<std::size_t>() == 0) view["byteOffset"] = put(bytes_of_view(view));
      views_.push_back(std::move(view));
    };
    if (json_.contains("images")) {
      for (json& image : json_["images"]) keep(image);
    }
    for (std::size_t i = 0; i < roles_.size(); ++i) {
      if (roles_[i] == Role::kKept) keep(json_["accessors"][i]);
    }
  }

  std::size_t put(std::string_view bytes) {
    const std::size_t at = buffer_.size();
    buffer_ += bytes;
    buffer_.resize(aligned_to_word(buffer_.size()), '\0');
    return at;
  }

  bool is_packed(std::size_t accessor) const { return roles_[accessor] != Role::kKept; }

  void add_primitive(const json& primitive) {
    std::map<std::size_t, Rows> read_rows;  // by accessor
    std::vector<std::size_t> attributes;
    for (const json& accessor : primitive.at("attributes")) attributes.push_back(accessor);
    std::vector<std::size_t> all = attributes;
    if (primitive.contains("indices")) all.push_back(primitive["indices"]);
    for (const std::size_t accessor : all) {
      if (is_packed(accessor) && !is_done_[accessor]) read_rows[accessor] = read(accessor);
    }
    const bool is_alone =
        primitive.contains("indices") && std::ranges::all_of(all, [&](std::size_t accessor) {
          return is_packed(accessor) && uses_[accessor] == 1;
        });
    if (is_alone) reorder(attributes, all.back(), !is_blended(primitive), read_rows);
    for (const auto& [accessor, rows] : read_rows) add(accessor, rows);
    if (waiting_bytes_ > kBytesTogether) compress_waiting();
  }

  /// Whether the order of triangles can be seen.
  bool is_blended(const json& primitive) const {
    if (!primitive.contains("material")) return false;
    const auto material = primitive["material"].get<std::size_t>();
    return json_.at("materials").at(material).value("alphaMode", "OPAQUE") == "BLEND";
  }

  /// Triangles and vertices in an order that compresses better.
  static void reorder(const std::vector<std::size_t>& attributes,
                      std::size_t index_accessor,
                      bool moves_triangles,
                      std::map<std::size_t, Rows>& rows) {
    const std::size_t vertices = rows.at(attributes.front()).count();
    std::vector<std::uint32_t> indices = indices_of(rows.at(index_accessor));
    const bool is_valid =
        std::ranges::all_of(indices, [&](std::uint32_t i) { return i < vertices; }) &&
        std::ranges::all_of(attributes,
                            [&](std::size_t a) { return rows.at(a).count() == vertices; });
    if (!is_valid) refuse_gltf("the attributes of a primitive differ in length");
    if (moves_triangles) {
      const std::vector<std::uint32_t> before = indices;
      meshopt_optimizeVertexCache(indices.data(), before.data(), before.size(), vertices);
    }
    // Vertices without a triangle would get no place.
    std::vector<unsigned> remap(vertices);
    if (meshopt_optimizeVertexFetchRemap(remap.data(), indices.data(), indices.size(), vertices) ==
        vertices) {
      meshopt_remapIndexBuffer(indices.data(), indices.data(), indices.size(), remap.data());
      for (const std::size_t attribute : attributes) {
        Rows& own = rows.at(attribute);
        const Bytes before = own.bytes;
        meshopt_remapVertexBuffer(
            own.bytes.data(), before.data(), vertices, own.each, remap.data());
      }
    }
    rows.at(index_accessor) = rows_of(indices, rows.at(index_accessor).each);
  }

  void add(std::size_t index, const Rows& rows) {
    json& accessor = json_["accessors"][index];
    switch (roles_[index]) {
      case Role::kPosition: {
        constexpr double kSteps = 32768.0;
        const std::vector<float> values = floats_of(rows);
        const int exponent = exponent_for(largest_extent(values) / kSteps, values);
        set_bounds(accessor, values, exponent);
        wait(index, {"ATTRIBUTES", "EXPONENTIAL", rows.each}, in_steps(values, exponent));
        break;
      }
      case Role::kUv: {
        constexpr double kStep = 1.0 / 4096.0;
        const std::vector<float> values = floats_of(rows);
        for (const char* bound : {"min", "max"}) accessor.erase(bound);
        wait(index,
             {"ATTRIBUTES", "EXPONENTIAL", rows.each},
             in_steps(values, exponent_for(kStep, values)));
        break;
      }
      case Role::kNormal:
        add_directions(index, rows, 8);
        break;
      case Role::kTangent:
        // They turn the normals of a picture, whose errors are larger.
        add_directions(index, rows, 6);
        break;
      case Role::kIndices:
        add_indices(index, rows);
        break;
      default:
        wait(index, {"ATTRIBUTES", "NONE", aligned_to_word(rows.each)}, padded(rows).bytes);
    }
  }

  void add_directions(std::size_t index, const Rows& rows, int bits) {
    json& accessor = json_["accessors"][index];
    for (const char* bound : {"min", "max"}) accessor.erase(bound);
    accessor["componentType"] = static_cast<int>(ComponentType::kByte);
    accessor["normalized"] = true;
    const std::size_t width = rows.each / sizeof(float);
    wait(index, {"ATTRIBUTES", "OCTAHEDRAL", 4}, octahedral(floats_of(rows), width, bits));
  }

  /// In two or four bytes, as compression requires.
  void add_indices(std::size_t index, const Rows& rows) {
    if (rows.each > 1) {
      wait(index, {"TRIANGLES", "NONE", rows.each}, rows.bytes);
      return;
    }
    json_["accessors"][index]["componentType"] = static_cast<int>(ComponentType::kUshort);
    wait(index, {"TRIANGLES", "NONE", 2}, rows_of(indices_of(rows), 2).bytes);
  }

  void wait(std::size_t accessor, const Format& format, const Bytes& bytes) {
    Batch& batch = waiting_[format];
    batch.starts.emplace_back(accessor, batch.bytes.size());
    batch.bytes.insert(batch.bytes.end(), bytes.begin(), bytes.end());
    waiting_bytes_ += bytes.size();
    is_done_[accessor] = true;
  }

  void compress_waiting() {
    for (const auto& [format, batch] : waiting_) {
      for (const auto& [accessor, start] : batch.starts) {
        json_["accessors"][accessor]["bufferView"] = views_.size();
        json_["accessors"][accessor]["byteOffset"] = start;
      }
      views_.push_back(compressed_view(format, batch.bytes));
    }
    waiting_.clear();
    waiting_bytes_ = 0;
  }

  json compressed_view(const Format& format, const Bytes& bytes) {
    const bool is_index = format.mode == "TRIANGLES";
    const PackedStream stream{.attribute = is_index ? "" : "any", .stride = format.stride};
    const Bytes small = compressed(stream, bytes);
    json packed{{"buffer", 0},
                {"byteOffset", put({reinterpret_cast<const char*>(small.data()), small.size()})},
                {"byteLength", small.size()},
                {"byteStride", format.stride},
                {"count", bytes.size() / format.stride},
                {"mode", format.mode}};
    if (format.filter != "NONE") packed["filter"] = format.filter;
    json view{{"buffer", json_["buffers"].size()},
              {"byteOffset", unpacked_size_},
              {"byteLength", bytes.size()},
              {"extensions", {{kCompressionName, std::move(packed)}}}};
    if (!is_index) view["byteStride"] = format.stride;
    unpacked_size_ += aligned_to_word(bytes.size());
    return view;
  }

  void require(const char* extension) {
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
      json& names = json_[list];
      if (!names.is_array()) names = json::array();
      if (std::ranges::find(names, json(extension)) == names.end()) names.push_back(extension);
    }
  }

  std::string assembled() {
    json_["bufferViews"] = std::move(views_);
    json_["buffers"][0]["byteLength"] = buffer_.size();
    json_["buffers"].push_back({{"byteLength", unpacked_size_},
                                {"extensions", {{kCompressionName, {{"fallback", true}}}}}});
    require(kCompressionName);
    require(kQuantizationName);
    std::string text = json_text(json_);
    text.resize(aligned_to_word(text.size()), ' ');
    return glb_head(text.size(), buffer_.size()) + text + glb_buffer_head(buffer_.size()) + buffer_;
  }

  json json_;
  std::string_view source_;
  std::vector<Role> roles_{};  ///< of accessors
  std::vector<std::size_t> uses_{};
  std::vector<bool> is_done_{};
  std::map<Format, Batch> waiting_{};
  std::size_t waiting_bytes_ = 0;
  std::size_t unpacked_size_ = 0;
  json views_ = json::array();
  std::string buffer_{};
};

}  // namespace

std::string packed_glb(std::string_view glb) {
  GlbParts parts = glb_parts(glb);
  const json& description = parts.description;
  const bool has_buffer = parts.buffer && description.contains("buffers") &&
                          !description["buffers"].empty() &&
                          !description["buffers"][0].contains("uri");
  if (!has_buffer || !description.contains("meshes") || !has_known_references(description)) {
    return std::string(glb);
  }
  try {
    std::string packed = GlbPacker(std::move(parts.description), *parts.buffer).packed();
    return packed.size() < glb.size() ? packed : std::string(glb);
  } catch (const json::exception&) {
    refuse_gltf("a value has another type than glTF requires");
  }
}

std::string deflated(std::string_view bytes) {
  const auto count = static_cast<uLong>(bytes.size());
  if (count != bytes.size()) throw std::bad_alloc();  // zlib counts with 32 bits on Windows
  uLongf size = compressBound(count);
  std::string result(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(result.data()),
                               &size,
                               reinterpret_cast<const Bytef*>(bytes.data()),
                               count,
                               Z_DEFAULT_COMPRESSION);
  if (status != Z_OK) throw std::bad_alloc();  // the only error of a sufficient buffer
  result.resize(size);
  return result;
}

}  // namespace silvafit::tree
