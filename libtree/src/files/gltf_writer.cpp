// SPDX-License-Identifier: MIT
// Binary glTF, and glTF with a separate buffer file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "files/format_writers.hpp"
#include "files/glb_container.hpp"
#include "files/gltf_animation.hpp"
#include "files/gltf_buffers.hpp"
#include "files/gltf_materials.hpp"
#include "files/packed_part.hpp"
#include "files/spool.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/base/json_text.hpp"

namespace silvafit::tree {
namespace {

/// To a micrometer, so that differences of coordinates have few digits.
double rounded(double meters) {
  constexpr double kPerMeter = 1e6;
  const double value = std::round(meters * kPerMeter) / kPerMeter;
  return value == 0.0 ? 0.0 : value;  // no -0
}

/// Vertices are floats: digits beyond these are their rounding.
double without_rounding(double value) {
  constexpr double kSteps = 1e5;
  return std::round(kSteps * value) / kSteps;
}

nlohmann::ordered_json json_of(const CrownRadii& radii) {
  return {{"e", without_rounding(radii.east_m)},
          {"w", without_rounding(radii.west_m)},
          {"s", without_rounding(radii.south_m)},
          {"n", without_rounding(radii.north_m)}};
}

bool is_ground(const ModelPart& part) { return part.part == "ground"; }

class GltfWriter final : public SceneWriter {
 public:
  GltfWriter(std::filesystem::path path, bool binary, const SceneOptions& options)
      : path_(std::move(path)),
        binary_(binary),
        options_(options),
        buffers_(path_, options.compress),
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
    // The ground is as wide as the stand: quantization steps of its width would be too coarse for
    // its heights.
    const bool has_steps = options_.quantize && std::none_of(parts.begin(), parts.end(), is_ground);
    if (has_steps) pack_options.step_m = quantization_step_m(meshes);
    WaitingModel model{.name = name};
    for (const ModelPart& part : parts) {
      if (part.mesh->indices.empty()) continue;
      const std::size_t first = streams_.size();
      for (PackedStream& stream : pack(*part.mesh, pack_options)) {
        waiting_bytes_ += stream.bytes.size();
        streams_.push_back(std::move(stream));
      }
      model.primitives.push_back(
          {first, streams_.size() - first, materials_.number_of(part), part.part});
    }
    const std::size_t mesh = meshes_.count() + waiting_.size();
    waiting_.push_back(std::move(model));
    if (!options_.compress || waiting_bytes_ > kBytesTogether) write_waiting();
    // Checked first, before a million trees are grown.
    if (binary_) check_binary_size(buffers_.size());
    const double scale = has_steps ? pack_options.step_m : 1.0;
    models_.push_back({mesh, scale, options_.instancing ? name : std::string(), {}});
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
    models_.pop_back();  // this model has only one position
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
                                 json_quoted(name + "@" + model.name),
                                 shown,
                                 shown,
                                 shown,
                                 mesh_node));
      animation_.add_scales(node, model.shown, Interpolation::kStep, 1.0);
      animation_.add_scales(
          mesh_node, model.size, Interpolation::kLinear, models_[model.model].step_m);
      children += (children.empty() ? "" : ",") + std::to_string(node);
    }
    std::string node = fmt::format("{{\"name\":{},\"translation\":{},\"children\":[{}]",
                                   json_quoted(name),
                                   json_triple(translation_of({.position = position})),
                                   children);
    if (!extras.empty()) node += ",\"extras\":" + extras;
    roots_.add(std::to_string(nodes_.add(node + '}')));
  }

  std::vector<std::filesystem::path> other_files() const override {
    if (binary_) return {};
    return {buffer_path()};
  }

  std::size_t finish() override {
    write_waiting();
    if (options_.instancing) write_instances();
    if (nodes_.count() == 0) throw GeometryError("a scene needs at least one tree");
    return binary_ ? write_binary() : write_with_buffer();
  }

 private:
  static constexpr std::size_t kPerInstance = 7;  // translation, scale, number
  struct PlacedModel {
    std::size_t mesh = 0;
    double step_m = 1.0;  ///< of quantized positions
    std::string name{};
    std::vector<float> instances{};  ///< kPerInstance per instance
  };

  /// Of a part, with its streams.
  struct WaitingPrimitive {
    std::size_t first = 0;
    std::size_t count = 0;
    std::size_t material = 0;
    std::string part{};
  };
  struct WaitingModel {
    std::string name{};
    std::vector<WaitingPrimitive> primitives{};
  };
  /// Uncompressed bytes of models that share views.
  static constexpr std::size_t kBytesTogether = std::size_t{1} << 18U;

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
    std::string node = fmt::format("{{\"name\":{},\"mesh\":{}", json_quoted(name), model.mesh);
    node += fmt::format(",\"translation\":{}", json_triple(translation_of(placement)));
    const std::array<double, 3> scale = scale_of(model, placement);
    if (scale != std::array<double, 3>{1.0, 1.0, 1.0}) {
      // Seven digits are the precision of a viewer's floats.
      node += fmt::format(",\"scale\":[{:.7g},{:.7g},{:.7g}]", scale[0], scale[1], scale[2]);
    }
    if (!extras.empty()) node += ",\"extras\":" + extras;
    roots_.add(std::to_string(nodes_.add(node + '}')));
  }

  /// As large as at its first keyframe with scale 1.
  std::size_t add_resting_node(const PlacedModel& placed, const AnimatedModel& model) {
    const double step = placed.step_m;
    std::string node = fmt::format("{{\"mesh\":{}", placed.mesh);
    if (step != 1.0 || !model.size.empty()) {
      node += fmt::format(",\"scale\":[{0:.7g},{0:.7g},{0:.7g}]", step);
    }
    return nodes_.add(node + '}');
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
      const std::size_t translation = instance_attribute(model, 0, 3);
      const std::size_t scale = instance_attribute(model, 3, 3);
      const std::size_t number = instance_attribute(model, 6, 1);
      const std::string node = fmt::format(
          "{{\"name\":{},\"mesh\":{},\"extensions\":{{\"EXT_mesh_gpu_instancing\":"
          "{{\"attributes\":{{\"TRANSLATION\":{},\"SCALE\":{},\"_TREE\":{}}}}}}}}}",
          json_quoted(model.name),
          model.mesh,
          translation,
          scale,
          number);
      roots_.add(std::to_string(nodes_.add(node)));
    }
  }

  /// \returns the accessor of `each` values of every instance, starting at `from`
  std::size_t instance_attribute(const PlacedModel& model, std::size_t from, std::size_t each) {
    std::vector<float> values;
    values.reserve(model.instances.size() / kPerInstance * each);
    for (std::size_t at = from; at < model.instances.size(); at += kPerInstance) {
      for (std::size_t k = 0; k < each; ++k) values.push_back(model.instances[at + k]);
    }
    return buffers_.add_floats(values, each);
  }

  /// Models whose streams are not in the buffer yet: several share views, because the description
  /// of a view is not much shorter than the compressed part of a small tree.
  void write_waiting() {
    const std::vector<std::size_t> accessors = buffers_.add_streams(streams_);
    for (const WaitingModel& model : waiting_) {
      std::string primitives;
      for (const WaitingPrimitive& primitive : model.primitives) {
        primitives += (primitives.empty() ? "" : ",") + text_of(primitive, accessors);
      }
      meshes_.add(
          fmt::format("{{\"name\":{},\"primitives\":[{}]}}", json_quoted(model.name), primitives));
    }
    waiting_.clear();
    streams_.clear();
    waiting_bytes_ = 0;
  }

  std::string text_of(const WaitingPrimitive& primitive,
                      const std::vector<std::size_t>& accessors) const {
    // The indices are the last stream.
    const std::size_t indices = primitive.first + primitive.count - 1;
    std::string attributes;
    for (std::size_t i = primitive.first; i < indices; ++i) {
      attributes += fmt::format(
          "{}\"{}\":{}", attributes.empty() ? "" : ",", streams_[i].attribute, accessors[i]);
    }
    return fmt::format(
        "{{\"attributes\":{{{}}},\"indices\":{},\"material\":{},\"extras\":{{\"part\":{}}}}}",
        attributes,
        accessors[indices],
        primitive.material,
        json_quoted(primitive.part));
  }

  std::string extensions() const {
    std::string names;
    const bool is_scaled = (options_.quantize || options_.compress) && materials_.has_textures();
    for (const auto& [used, name] : {std::pair{options_.instancing, "EXT_mesh_gpu_instancing"},
                                     std::pair{is_scaled, "KHR_texture_transform"},
                                     std::pair{options_.quantize, "KHR_mesh_quantization"},
                                     std::pair{options_.compress, "EXT_meshopt_compression"}}) {
      if (used) names += (names.empty() ? "\"" : ",\"") + std::string(name) + '"';
    }
    if (names.empty()) return {};
    // Required, because a program without support would show one tree, or none, without an error.
    return fmt::format(",\"extensionsUsed\":[{0}],\"extensionsRequired\":[{0}]", names);
  }

  /// \param uri          of the buffer; empty: it follows in the same file
  /// \param fingerprint  of a buffer in a separate file, by which readers recognize that the two
  ///                     files belong together
  Pieces description(const std::string& uri, const std::string& fingerprint) {
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
    pieces.add("]" + animation_.json(options_.times) + ",\"meshes\":[");
    pieces.add(meshes_.spool());
    pieces.add("],\"materials\":[" + materials_.materials() + "]," + materials_.textures() +
               "\"accessors\":[");
    pieces.add(buffers_.accessors());
    pieces.add("],\"bufferViews\":[");
    pieces.add(buffers_.views());
    pieces.add("],\"buffers\":[" + buffers_.description(uri, fingerprint) + "]}");
    return pieces;
  }

  void check_binary_size(std::size_t bytes) const {
    if (bytes <= options_.longest_glb) return;
    constexpr double kGigabyte = 1024.0 * 1024.0 * 1024.0;
    throw GeometryError(
        fmt::format("the scene exceeds the {:.3g} GB of a GLB file; share models, use a coarser "
                    "level of detail or fewer plots, or write glTF",
                    static_cast<double>(options_.longest_glb) / kGigabyte));
  }

  std::size_t write_binary() {
    Pieces text = description({}, {});
    text.add(std::string(aligned_to_word(text.size()) - text.size(), ' '));
    const std::size_t total = glb_size(text.size(), buffers_.size());
    check_binary_size(total);
    AtomicFile file(path_);
    file.stream() << glb_head(text.size(), buffers_.size());
    text.write_to(file.stream());
    file.stream() << glb_buffer_head(buffers_.size());
    buffers_.data().copy_to(file.stream());
    file.commit();
    return total;
  }

  std::size_t write_with_buffer() {
    AtomicFile buffer(buffer_path());
    Fingerprint fingerprint;
    buffers_.data().read([&](std::string_view bytes) {
      buffer.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      fingerprint.add(bytes);
    });
    AtomicFile file(path_);
    const Pieces text = description(uri_of(buffer_path().filename().string()), fingerprint.text());
    text.write_to(file.stream());
    // The buffer first, so that a description never refers to a missing file.
    commit_together({&buffer, &file});
    return text.size() + buffers_.size();
  }

  std::filesystem::path buffer_path() const {
    return std::filesystem::path(path_).replace_extension(".bin");
  }

  /// Bytes that are not allowed in a URI become %XX.
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
  GltfBuffers buffers_;
  ArraySpool meshes_;
  ArraySpool nodes_;
  ArraySpool roots_;
  GltfMaterials materials_{buffers_, options_.quantize || options_.compress, options_.threads};
  GltfAnimation animation_{buffers_};
  std::vector<PlacedModel> models_{};
  std::vector<WaitingModel> waiting_{};
  std::vector<PackedStream> streams_{};  ///< of the waiting models
  std::size_t waiting_bytes_ = 0;
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
    const std::size_t of_pictures =
        part.texture == nullptr
            ? 0
            : part.uvs.size() + (part.normal_texture == nullptr ? 0 : part.tangents.size());
    size += sizeof(float) * (part.positions.size() + part.normals.size() + of_pictures) +
            part.colors.size() + aligned_to_word(index_size * part.indices.size());
  }
  return size;
}

std::string tree_extras(const SceneTree& tree) {
  nlohmann::ordered_json extras{{"plot", tree.plot},
                                {"tree", tree.tree},
                                {"species", tree.species},
                                {"preset", tree.preset},
                                {"h", without_rounding(tree.measured.h_m)},
                                {"hcb", without_rounding(tree.measured.hcb_m)},
                                {"dbh", without_rounding(tree.measured.dbh_cm)},
                                {"cw", without_rounding(tree.measured.radii.width_m())},
                                {"radii", json_of(tree.measured.radii)}};
  if (tree.removed_share) extras["removed_share"] = *tree.removed_share;
  if (!tree.notes.empty()) {
    nlohmann::ordered_json notes = nlohmann::ordered_json::array();
    for (const Note& note : tree.notes) notes.push_back(note.about + ": " + note.text);
    extras["notes"] = std::move(notes);
  }
  return json_text(extras);
}

}  // namespace silvafit::tree
