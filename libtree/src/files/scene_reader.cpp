// SPDX-License-Identifier: MIT
#include "silvafit/tree/scene_reader.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "files/glb_container.hpp"
#include "files/gltf_document.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/fingerprint.hpp"

namespace silvafit::tree {
namespace {

using nlohmann::json;

template <typename Read>
auto guarded(Read read) {
  try {
    return read();
  } catch (const json::exception& error) {
    // The value with this name has another type than glTF requires. The library puts a mark before
    // its message: "[json.exception.type_error.302] type must be number, ...".
    const std::string_view message = error.what();
    const std::size_t mark = message.find("] ");
    refuse_gltf(std::string(message.substr(mark == std::string_view::npos ? 0 : mark + 2)));
  }
}

ReadScene read_glb_unguarded(std::string_view bytes) {
  GlbParts parts = glb_parts(bytes);
  std::vector<std::string> buffers;
  if (parts.buffer) buffers.emplace_back(*parts.buffer);
  return read_document(std::move(parts.description), std::move(buffers));
}

/// The message for OBJ, PLY and tables, which are often given instead of scenes.
void require_gltf(const std::string& bytes) {
  // A byte order mark may precede the text.
  const std::size_t start = bytes.find_first_not_of("\xEF\xBB\xBF \t\r\n");
  if (start != std::string::npos && bytes[start] == '{') return;
  throw InputError("not a GLB or glTF scene; `silvafit grow` writes one with `scene`");
}

std::string unescaped(const std::string& uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      name += uri[i];
      continue;
    }
    unsigned value = 0;
    for (std::size_t k = i + 1; k < i + 3; ++k) {
      const char c = k < uri.size() ? uri[k] : '?';
      const bool digit = c >= '0' && c <= '9';
      const bool upper = c >= 'A' && c <= 'F';
      const bool lower = c >= 'a' && c <= 'f';
      if (!digit && !upper && !lower) refuse_gltf("a URI has an invalid % escape");
      value =
          16 * value + static_cast<unsigned>(digit ? c - '0' : (upper ? c - 'A' : c - 'a') + 10);
    }
    name += static_cast<char>(value);
    i += 2;
  }
  return name;
}

/// If the program was killed, or only one file was copied, the description and the buffer may be
/// those of different scenes.
void require_own_buffer(const json& buffer, const std::string& bytes, const std::string& uri) {
  const auto length = buffer.find("byteLength");
  const bool is_short = length != buffer.end() && length->is_number_unsigned() &&
                        length->get<std::size_t>() > bytes.size();
  const auto extras = buffer.find("extras");
  const std::string mark =
      extras == buffer.end() ? std::string() : gltf_text(*extras, "fingerprint");
  const bool is_other = mark.starts_with("fnv1a64:") && mark != fingerprint(bytes);
  if (!is_short && !is_other) return;
  refuse_gltf("its buffer " + uri +
              " is not the one that was written with it; write the scene again");
}

ReadScene read_gltf_unguarded(const std::filesystem::path& path, const std::string& bytes) {
  require_gltf(bytes);
  json description = gltf_description(bytes);
  std::vector<std::string> buffers;
  std::set<std::filesystem::path> names;
  if (description.contains("buffers")) {
    for (const json& buffer : description["buffers"]) {
      const std::string uri = gltf_text(buffer, "uri");
      if (uri.empty()) {
        buffers.emplace_back();  // only compressed views may refer to it
        continue;
      }
      const std::filesystem::path name = unescaped(uri);
      if (name.has_parent_path() || uri.find(':') != std::string::npos) {
        refuse_gltf("its buffer is not a file in the same folder: " + uri);
      }
      if (!names.insert(name).second) refuse_gltf("two of its buffers are the same file: " + uri);
      buffers.push_back(read_file(path.parent_path() / name, kLargestScene));
      require_own_buffer(buffer, buffers.back(), uri);
    }
  }
  return read_document(std::move(description), std::move(buffers));
}

}  // namespace

bool is_flattened(const std::array<double, 16>& transform) {
  const double volume =
      Eigen::Map<const Eigen::Matrix4d>(transform.data()).topLeftCorner<3, 3>().determinant();
  // Then the directions of normals are unknown in single precision, too.
  return !(std::abs(volume) >= double{std::numeric_limits<float>::min()});
}

std::array<double, 3> ReadInstance::moved(std::array<double, 3> point) const {
  const Eigen::Vector4d at{point[0], point[1], point[2], 1.0};
  const Eigen::Vector4d there = Eigen::Map<const Eigen::Matrix4d>(transform.data()) * at;
  return {there[0], there[1], there[2]};
}

std::size_t ReadScene::triangle_count() const {
  std::vector<std::size_t> of_model;
  for (const ReadModel& model : models) {
    std::size_t count = 0;
    for (const ReadPart& part : model.parts) count += part.mesh.triangle_count();
    of_model.push_back(count);
  }
  std::size_t sum = 0;
  for (const ReadInstance& instance : instances) sum += of_model[instance.model];
  return sum;
}

ReadScene read_glb(std::string_view bytes) {
  return guarded([&] { return read_glb_unguarded(bytes); });
}

json glb_description(std::string_view bytes) { return glb_parts(bytes).description; }

ReadScene read_scene(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kLargestScene);
  try {
    const bool is_binary = bytes.compare(0, 4, "glTF") == 0;
    ReadScene scene = guarded(
        [&] { return is_binary ? read_glb_unguarded(bytes) : read_gltf_unguarded(path, bytes); });
    scene.file = path.string();
    return scene;
  } catch (const InputError& error) {
    if (!error.place().file.empty()) throw;
    throw InputError(error.message(), {.file = path.string()});
  }
}

}  // namespace silvafit::tree
