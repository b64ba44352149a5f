// SPDX-License-Identifier: MIT
// Binary glTF and glTF with its buffer beside it.
#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "format_writers.hpp"
#include "gltf_animation.hpp"
#include "packed_part.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "spool.hpp"

namespace silvafit::tree {
namespace {

using nlohmann::ordered_json;
constexpr std::size_t kAlignment = 4;

std::size_t aligned(std::size_t size) { return (size + kAlignment - 1) / kAlignment * kAlignment; }

/// To a micrometer, so that differences of coordinates have few digits.
double rounded(double meters) {
  constexpr double kPerMeter = 1e6;
  const double value = std::round(meters * kPerMeter) / kPerMeter;
  return value == 0.0 ? 0.0 : value;  // no -0
}

std::string triple(const std::array<double, 3>& values) {
  return fmt::format("[{},{},{}]", values[0], values[1], values[2]);
}

ordered_json json_of(const CrownRadii& radii) {
  return {{"e", radii.east_m}, {"w", radii.west_m}, {"s", radii.south_m}, {"n", radii.north_m}};
}

}  // namespace

std::string tree_extras(const SceneTree& tree) {
  ordered_json extras{{"plot", tree.plot},
                      {"tree", tree.tree},
                      {"species", tree.species},
                      {"preset", tree.preset},
                      {"h", tree.measured.h_m},
                      {"hcb", tree.measured.hcb_m},
                      {"dbh", tree.measured.dbh_cm},
                      {"cw", tree.measured.radii.width_m()},
                      {"radii", json_of(tree.measured.radii)}};
  if (tree.removed_share) extras["removed_share"] = *tree.removed_share;
  if (!tree.notes.empty()) {
    ordered_json notes = ordered_json::array();
    for (const Note& note : tree.notes) notes.push_back(note.about + ": " + note.text);
    extras["notes"] = std::move(notes);
  }
  return extras.dump();
}

namespace {

std::string quoted(const std::string& text) { return ordered_json(text).dump(); }

/// A JSON array that grows on a spool.
class ArraySpool {
 public:
  explicit ArraySpool(const std::filesystem::path& beside) : spool_(beside) {}

  std::size_t add(const std::string& item) {
    if (count_ > 0) spool_.append(",");
    spool_.append(item);
    return count_++;
  }
  std::size_t count() const { return count_; }
  Spool& spool() { return spool_; }

 private:
  Spool spool_;
  std::size_t count_ = 0;
};

/// Text and spools one after the other.
class Pieces {
 public:
  void add(std::string text) { pieces_.emplace_back(std::move(text), nullptr); }
  void add(Spool& spool) { pieces_.emplace_back(std::string(), &spool); }

  std::size_t size() const {
    std::size_t sum = 0;
    for (const auto& [text, spool] : pieces_) sum += spool != nullptr ? spool->size() : text.size();
    return sum;
  }
  void write_to(std::ostream& to) const {
    for (const auto& [text, spool] : pieces_) {
      if (spool != nullptr) {
        spool->copy_to(to);
      } else {
        to << text;
      }
    }
  }

 private:
  std::vector<std::pair<std::string, Spool*>> pieces_;
};

std::string word(std::size_t value) {
  std::string bytes(4, '\0');
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[i] = static_cast<char>(value >> (8 * i) & 0xFFU);
  }
  return bytes;
}

class GltfWriter final : public SceneWriter {
 public:
  GltfWriter(std::filesystem::path path, bool binary, const SceneOptions& options)
      : path_(std::move(path)),
        binary_(binary),
        options_(options),
        data_(path_),
        views_(path_),
        accessors_(path_),
        meshes_(path_),
        nodes_(path_),
        roots_(path_) {
    options_.quantize = options.quantize || options.compress;
  }

  Model add_model(const std::string& name, const std::vector<ModelPart>& parts) override {
    PackOptions pack_options{.quantize = options_.quantize, .compress = options_.compress};
    std::vector<const MeshPart*> meshes;
    for (const ModelPart& part : parts) {
      if (!part.mesh->indices.empty()) meshes.push_back(part.mesh);
    }
    if (meshes.empty()) throw GeometryError("the model " + name + " has no triangles");
    pack_options.step_m = options_.quantize ? quantization_step_m(meshes) : 1.0;
    std::string primitives;
    for (const ModelPart& part : parts) {
      if (part.mesh->indices.empty()) continue;
      if (!primitives.empty()) primitives += ',';
      primitives += primitive(part, pack_options);
    }
    const std::size_t mesh =
        meshes_.add(fmt::format("{{\"name\":{},\"primitives\":[{}]}}", quoted(name), primitives));
    models_.push_back({mesh, pack_options.step_m, options_.instancing ? name : std::string(), {}});
    return models_.size() - 1;
  }

  void place(Model model,
             const std::string& name,
             const Placement& placement,
             std::size_t number) override {
    if (options_.instancing && number != kNoTree) {
      add_instance(models_[model], placement, number);
    } else {
      add_node(models_[model], name, placement, {});
    }
  }

  void add_tree(const SceneTree& tree) override {
    const Model model = add_model(tree.name(), parts_of(tree.mesh, tree.preset));
    add_node(models_[model], tree.name(), {.position = tree.position}, tree_extras(tree));
    models_.pop_back();  // nothing else stands at this model's place
  }

  void animate(const std::string& name,
               const Position& position,
               const std::vector<AnimatedModel>& models,
               const std::string& extras) override {
    std::string children;
    for (const AnimatedModel& model : models) {
      const std::size_t mesh_node = add_resting_node(models_[model.model], model);
      const double shown = model.at_rest ? 1.0 : 0.0;
      const std::size_t node =
          nodes_.add(fmt::format("{{\"name\":{},\"scale\":[{},{},{}],\"children\":[{}]}}",
                                 quoted(name + "@" + model.name),
                                 shown,
                                 shown,
                                 shown,
                                 mesh_node));
      add_channel(node, model.shown, "STEP", 1.0);
      add_channel(mesh_node, model.size, "LINEAR", models_[model.model].step_m);
      children += (children.empty() ? "" : ",") + std::to_string(node);
    }
    std::string node = fmt::format("{{\"name\":{},\"translation\":{},\"children\":[{}]",
                                   quoted(name),
                                   triple(translation_of({.position = position})),
                                   children);
    if (!extras.empty()) node += ",\"extras\":" + extras;
    roots_.add(std::to_string(nodes_.add(node + '}')));
  }

  std::size_t finish() override {
    if (options_.instancing) write_instances();
    if (nodes_.count() == 0) throw GeometryError("a scene needs at least one tree");
    return binary_ ? write_binary() : write_with_buffer();
  }

  std::string bytes() {
    if (nodes_.count() == 0) throw GeometryError("a scene needs at least one tree");
    std::ostringstream stream;
    write_binary_to(stream);
    return std::move(stream).str();
  }

 private:
  struct PlacedModel {
    std::size_t mesh = 0;
    double step_m = 1.0;  ///< of quantized positions
    std::string name{};
    std::vector<float> instances{};  ///< 7 a place: translation, scale, number
  };

  std::array<double, 3> translation_of(const Placement& placement) const {
    const Position& at = placement.position;
    return {rounded(at.x_m - options_.origin.x_m),
            rounded(at.z_m - options_.origin.z_m),
            rounded(-(at.y_m - options_.origin.y_m))};
  }

  static std::array<double, 3> scale_of(const PlacedModel& model, const Placement& placement) {
    return {placement.stretch_east * model.step_m,
            placement.stretch_up * model.step_m,
            placement.stretch_north * model.step_m};
  }

  void add_node(const PlacedModel& model,
                const std::string& name,
                const Placement& placement,
                const std::string& extras) {
    std::string node = fmt::format("{{\"name\":{},\"mesh\":{}", quoted(name), model.mesh);
    node += fmt::format(",\"translation\":{}", triple(translation_of(placement)));
    const std::array<double, 3> scale = scale_of(model, placement);
    if (scale != std::array<double, 3>{1.0, 1.0, 1.0}) {
      // Seven digits are what a viewer's floats hold.
      node += fmt::format(",\"scale\":[{:.7g},{:.7g},{:.7g}]", scale[0], scale[1], scale[2]);
    }
    if (!extras.empty()) node += ",\"extras\":" + extras;
    roots_.add(std::to_string(nodes_.add(node + '}')));
  }

  /// As large as at its first keyframe of full size.
  std::size_t add_resting_node(const PlacedModel& placed, const AnimatedModel& model) {
    const double step = placed.step_m;
    std::string node = fmt::format("{{\"mesh\":{}", placed.mesh);
    if (step != 1.0 || !model.size.empty()) {
      node += fmt::format(",\"scale\":[{0:.7g},{0:.7g},{0:.7g}]", step);
    }
    return nodes_.add(node + '}');
  }

  void add_channel(std::size_t node,
                   const std::vector<Keyframe>& keyframes,
                   const char* interpolation,
                   double step_m) {
    if (keyframes.empty()) return;
    std::vector<float> times;
    std::vector<float> scales;
    for (const Keyframe& keyframe : keyframes) {
      times.push_back(static_cast<float>(keyframe.time_s));
      for (const double scale : keyframe.scale)
        scales.push_back(static_cast<float>(step_m * scale));
    }
    const std::string sampler =
        fmt::format("{{\"input\":{},\"interpolation\":\"{}\",\"output\":{}}}",
                    keyframe_accessor(times, 1),
                    interpolation,
                    keyframe_accessor(scales, 3));
    animation_.add_scale_channel(node, sampler);
  }

  /// Many trees share their keyframes.
  std::size_t keyframe_accessor(const std::vector<float>& values, std::size_t each) {
    const auto [found, is_new] = keyframes_.try_emplace({each, values}, 0);
    if (!is_new) return found->second;
    const std::size_t view = plain_view(values.data(), values.size() * sizeof(float), 0, 0);
    std::string text =
        fmt::format("{{\"bufferView\":{},\"componentType\":5126,\"count\":{},\"type\":\"{}\"",
                    view,
                    values.size() / each,
                    each == 3 ? "VEC3" : "SCALAR");
    if (each == 1) text += fmt::format(",\"min\":[{}],\"max\":[{}]", values.front(), values.back());
    return found->second = accessors_.add(text + '}');
  }

  void add_instance(PlacedModel& model, const Placement& placement, std::size_t number) {
    for (const double value : translation_of(placement)) {
      model.instances.push_back(static_cast<float>(value));
    }
    for (const double value : scale_of(model, placement)) {
      model.instances.push_back(static_cast<float>(value));
    }
    model.instances.push_back(static_cast<float>(number));
  }

  void write_instances() {
    for (const PlacedModel& model : models_) {
      if (model.instances.empty()) continue;
      const std::size_t count = model.instances.size() / 7;
      const auto attribute = [&](std::size_t from, std::size_t each) {
        std::vector<float> values;
        values.reserve(count * each);
        for (std::size_t i = 0; i < count; ++i) {
          for (std::size_t k = 0; k < each; ++k)
            values.push_back(model.instances[7 * i + from + k]);
        }
        const std::size_t view = plain_view(values.data(), values.size() * sizeof(float), 0, 0);
        return accessors_.add(
            fmt::format("{{\"bufferView\":{},\"componentType\":5126,\"count\":{},\"type\":\"{}\"}}",
                        view,
                        count,
                        each == 3 ? "VEC3" : "SCALAR"));
      };
      const std::size_t translation = attribute(0, 3);
      const std::size_t scale = attribute(3, 3);
      const std::size_t number = attribute(6, 1);
      const std::string node = fmt::format(
          "{{\"name\":{},\"mesh\":{},\"extensions\":{{\"EXT_mesh_gpu_instancing\":{{\"attributes\":"
          "{{"
          "\"TRANSLATION\":{},\"SCALE\":{},\"_TREE\":{}}}}}}}}}",
          quoted(model.name),
          model.mesh,
          translation,
          scale,
          number);
      roots_.add(std::to_string(nodes_.add(node)));
    }
  }

  std::string primitive(const ModelPart& part, const PackOptions& pack_options) {
    const PackedPart packed = pack(*part.mesh, pack_options);
    std::string attributes;
    for (const PackedStream& stream : packed.attributes) {
      if (!attributes.empty()) attributes += ',';
      const bool is_position = stream.attribute == "POSITION";
      attributes += fmt::format(
          "\"{}\":{}", stream.attribute, accessor(stream, is_position ? &packed : nullptr));
    }
    return fmt::format(
        "{{\"attributes\":{{{}}},\"indices\":{},\"material\":{},\"extras\":{{\"part\":{}}}}}",
        attributes,
        accessor(packed.indices, nullptr),
        material(part),
        quoted(part.part));
  }

  std::size_t accessor(const PackedStream& stream, const PackedPart* bounds) {
    static constexpr std::array<const char*, 5> kTypes{"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    std::string text =
        fmt::format("{{\"bufferView\":{},\"componentType\":{},\"count\":{},\"type\":\"{}\"",
                    view(stream),
                    static_cast<int>(stream.component),
                    stream.count,
                    kTypes.at(static_cast<std::size_t>(stream.components)));
    if (stream.normalized) text += ",\"normalized\":true";
    if (bounds != nullptr) {
      text += fmt::format(",\"min\":{},\"max\":{}", triple(bounds->least), triple(bounds->most));
    }
    return accessors_.add(text + '}');
  }

  std::size_t view(const PackedStream& stream) {
    constexpr int kVertices = 34962;
    constexpr int kIndices = 34963;
    const bool is_index = stream.attribute.empty();
    const int target = is_index ? kIndices : kVertices;
    const std::size_t stride = is_index ? 0 : stream.stride;
    if (!options_.compress) {
      return plain_view(stream.bytes.data(), stream.bytes.size(), stride, target);
    }
    const std::size_t at = put(stream.packed.data(), stream.packed.size());
    const std::size_t unpacked_at = unpacked_size_;
    unpacked_size_ += aligned(stream.bytes.size());
    const std::string filter = stream.octahedral ? ",\"filter\":\"OCTAHEDRAL\"" : "";
    return views_.add(fmt::format(
        "{{\"buffer\":1,\"byteOffset\":{},\"byteLength\":{}{},\"target\":{},\"extensions\":{{"
        "\"EXT_meshopt_compression\":{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{},"
        "\"byteStride\":{},\"mode\":\"{}\",\"count\":{}{}}}}}}}",
        unpacked_at,
        stream.bytes.size(),
        is_index ? std::string() : fmt::format(",\"byteStride\":{}", stride),
        target,
        at,
        stream.packed.size(),
        stream.stride,
        is_index ? "TRIANGLES" : "ATTRIBUTES",
        stream.count,
        filter));
  }

  std::size_t plain_view(const void* bytes, std::size_t size, std::size_t stride, int target) {
    std::string text =
        fmt::format("{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}", put(bytes, size), size);
    if (stride > 0) text += fmt::format(",\"byteStride\":{}", stride);
    if (target > 0) text += fmt::format(",\"target\":{}", target);
    return views_.add(text + '}');
  }

  std::size_t put(const void* bytes, std::size_t size) {
    const std::size_t at = data_.size();
    data_.append(bytes, size);
    data_.append(std::string(aligned(size) - size, '\0'));
    return at;
  }

  std::size_t material(const ModelPart& part) {
    const auto [found, is_new] = materials_.try_emplace(part.material, materials_.size());
    if (is_new) {
      const Color& color = part.mesh->color;
      if (!material_text_.empty()) material_text_ += ',';
      const Texture* const picture = picture_of(*part.mesh);
      const bool is_cut_out = picture != nullptr && has_transparency(*picture);
      material_text_ += fmt::format(
          "{{\"name\":{},\"pbrMetallicRoughness\":{{\"baseColorFactor\":[{},{},{},1],{}"
          "\"metallicFactor\":0,\"roughnessFactor\":0.9}}{}{}}}",
          quoted(part.material),
          // glTF's factors end at 1, which a sum of shades may pass by rounding.
          std::min(color[0], 1.0),
          std::min(color[1], 1.0),
          std::min(color[2], 1.0),
          picture == nullptr
              ? std::string()
              : fmt::format("\"baseColorTexture\":{{\"index\":{}}},", texture(*picture)),
          is_cut_out ? ",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5" : "",
          part.mesh->double_sided ? ",\"doubleSided\":true" : "");
    }
    return found->second;
  }

  static const Texture* picture_of(const MeshPart& part) {
    return part.uvs.empty() ? nullptr : part.texture.get();
  }

  /// The number of a texture, whose picture is put into the buffer once.
  std::size_t texture(const Texture& picture) {
    const auto [found, is_new] = textures_.try_emplace(picture.name, textures_.size());
    if (is_new) {
      const std::string bytes = png_bytes(picture);
      if (!images_text_.empty()) images_text_ += ',';
      images_text_ += fmt::format("{{\"name\":{},\"mimeType\":\"image/png\",\"bufferView\":{}}}",
                                  quoted(picture.name),
                                  plain_view(bytes.data(), bytes.size(), 0, 0));
    }
    return found->second;
  }

  /// Every texture is its own picture; all repeat and are smoothed.
  std::string textures() const {
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

  std::string extensions() const {
    std::string names;
    for (const auto& [used, name] : {std::pair{options_.instancing, "EXT_mesh_gpu_instancing"},
                                     std::pair{options_.quantize, "KHR_mesh_quantization"},
                                     std::pair{options_.compress, "EXT_meshopt_compression"}}) {
      if (used) names += (names.empty() ? "\"" : ",\"") + std::string(name) + '"';
    }
    if (names.empty()) return {};
    // Required, since a program without them would show one tree, or none, without a word.
    return fmt::format(",\"extensionsUsed\":[{0}],\"extensionsRequired\":[{0}]", names);
  }

  std::string buffers(const std::string& uri) const {
    std::string text = fmt::format("{{\"byteLength\":{}", data_.size());
    if (!uri.empty()) text += ",\"uri\":" + quoted(uri);
    text += '}';
    if (options_.compress) {
      text += fmt::format(
          ",{{\"byteLength\":{},\"extensions\":{{\"EXT_meshopt_compression\":{{\"fallback\":true}}}"
          "}}}",
          unpacked_size_);
    }
    return text;
  }

  Pieces description(const std::string& uri) {
    const Position& origin = options_.origin;
    Pieces pieces;
    pieces.add(
        "{\"asset\":{\"generator\":\"silvafit\",\"version\":\"2.0\"}" + extensions() +
        ",\"scene\":0,\"scenes\":[{\"extras\":" +
        fmt::format(
            "{{\"origin\":{{\"x\":{},\"y\":{},\"z\":{}}}}}", origin.x_m, origin.y_m, origin.z_m) +
        ",\"nodes\":[");
    pieces.add(roots_.spool());
    pieces.add("]}],\"nodes\":[");
    pieces.add(nodes_.spool());
    pieces.add("]" + animation_.json() + ",\"meshes\":[");
    pieces.add(meshes_.spool());
    pieces.add("],\"materials\":[" + material_text_ + "]," + textures() + "\"accessors\":[");
    pieces.add(accessors_.spool());
    pieces.add("],\"bufferViews\":[");
    pieces.add(views_.spool());
    pieces.add("],\"buffers\":[" + buffers(uri) + "]}");
    return pieces;
  }

  std::size_t write_binary_to(std::ostream& stream) {
    Pieces json = description({});
    json.add(std::string(aligned(json.size()) - json.size(), ' '));
    constexpr std::size_t kHeaders = 12 + 8 + 8;
    const std::size_t total = kHeaders + json.size() + data_.size();
    if (total > std::numeric_limits<std::uint32_t>::max()) {
      throw GeometryError(
          "the scene is larger than the 4 GB of a GLB file; share models, use a coarser level of "
          "detail or fewer plots, or write glTF");
    }
    stream << "glTF" << word(2) << word(total) << word(json.size()) << "JSON";
    json.write_to(stream);
    stream << word(data_.size()) << std::string("BIN\0", 4);
    data_.copy_to(stream);
    return total;
  }

  std::size_t write_binary() {
    AtomicFile file(path_);
    const std::size_t size = write_binary_to(file.stream());
    file.commit();
    return size;
  }

  std::size_t write_with_buffer() {
    std::filesystem::path buffer_path = path_;
    buffer_path.replace_extension(".bin");
    AtomicFile buffer(buffer_path);
    data_.copy_to(buffer.stream());
    AtomicFile file(path_);
    const Pieces json = description(uri_of(buffer_path.filename().string()));
    json.write_to(file.stream());
    // The buffer first: a description never names one that is not there.
    buffer.commit();
    file.commit();
    return json.size() + data_.size();
  }

  /// Bytes that a URI does not take as they are become %XX.
  static std::string uri_of(const std::string& name) {
    std::string uri;
    for (const char c : name) {
      const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                            (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.' || c == '~';
      uri += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return uri;
  }

  std::filesystem::path path_;
  bool binary_;
  SceneOptions options_;
  Spool data_;
  ArraySpool views_;
  ArraySpool accessors_;
  ArraySpool meshes_;
  ArraySpool nodes_;
  ArraySpool roots_;
  std::map<std::string, std::size_t> materials_{};
  std::string material_text_{};
  std::map<std::string, std::size_t> textures_{};  ///< by name
  std::string images_text_{};
  std::vector<PlacedModel> models_{};
  GltfAnimation animation_{};
  std::map<std::pair<std::size_t, std::vector<float>>, std::size_t> keyframes_{};
  std::size_t unpacked_size_ = 0;
};

}  // namespace

std::unique_ptr<SceneWriter> make_gltf_writer(const std::filesystem::path& path,
                                              bool binary,
                                              const SceneOptions& options) {
  return std::make_unique<GltfWriter>(path, binary, options);
}

std::size_t glb_mesh_bytes(const Mesh& mesh) {
  std::size_t size = 0;
  for (const MeshPart& part : mesh.parts) {
    constexpr std::size_t kNarrow = 65535;
    const std::size_t index_size = part.vertex_count() < kNarrow ? 2 : 4;
    size += sizeof(float) * (part.positions.size() + part.normals.size() + part.uvs.size() +
                             part.tangents.size()) +
            part.colors.size() + aligned(index_size * part.indices.size());
  }
  return size;
}

std::string glb_bytes(const Scene& scene) {
  GltfWriter writer({}, true, {.origin = scene.origin});
  for (const SceneTree& tree : scene.trees) writer.add_tree(tree);
  return writer.bytes();
}

void write_glb(Scene scene, const std::filesystem::path& path) {
  const auto writer = open_scene(path, SceneFormat::kGlb, {.origin = scene.origin});
  for (SceneTree& tree : scene.trees) {
    writer->add_tree(tree);
    tree.mesh = {};
  }
  writer->finish();
}

}  // namespace silvafit::tree
