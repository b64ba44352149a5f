// SPDX-License-Identifier: MIT
#include "files/gltf_buffers.hpp"

#include <fmt/format.h>

#include <array>

namespace silvafit::tree {
namespace {

constexpr std::size_t kAlignment = 4;

/// glTF's target constants of a buffer view; 0 for none.
constexpr int kNoTarget = 0;
constexpr int kVertices = 34962;
constexpr int kIndices = 34963;

}  // namespace

std::size_t aligned_to_word(std::size_t size) {
  return (size + kAlignment - 1) / kAlignment * kAlignment;
}

GltfBuffers::GltfBuffers(const std::filesystem::path& beside, bool compress)
    : compress_(compress), data_(beside), views_(beside), accessors_(beside) {}

std::size_t GltfBuffers::add_attribute(const PackedStream& stream) {
  return add_stream(stream, {});
}

std::size_t GltfBuffers::add_positions(const PackedStream& stream, const PackedPart& bounds) {
  return add_stream(
      stream,
      fmt::format(",\"min\":{},\"max\":{}", json_triple(bounds.least), json_triple(bounds.most)));
}

std::size_t GltfBuffers::add_indices(const PackedStream& stream) { return add_stream(stream, {}); }

std::size_t GltfBuffers::add_stream(const PackedStream& stream, const std::string& more) {
  static constexpr std::array<const char*, 5> kTypes{"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  return accessors_.add(
      fmt::format("{{\"bufferView\":{},\"componentType\":{},\"count\":{},\"type\":\"{}\"{}{}}}",
                  view(stream),
                  static_cast<int>(stream.component),
                  stream.count,
                  kTypes.at(static_cast<std::size_t>(stream.components)),
                  stream.normalized ? ",\"normalized\":true" : "",
                  more));
}

std::size_t GltfBuffers::add_floats(const std::vector<float>& values,
                                    std::size_t each,
                                    bool bounded) {
  std::string text =
      fmt::format("{{\"bufferView\":{},\"componentType\":{},\"count\":{},\"type\":\"{}\"",
                  plain_view(values.data(), values.size() * sizeof(float), 0, kNoTarget),
                  static_cast<int>(ComponentType::kFloat),
                  values.size() / each,
                  each == 3 ? "VEC3" : "SCALAR");
  if (bounded) text += fmt::format(",\"min\":[{}],\"max\":[{}]", values.front(), values.back());
  return accessors_.add(text + '}');
}

std::size_t GltfBuffers::add_view(const std::string& bytes) {
  return plain_view(bytes.data(), bytes.size(), 0, kNoTarget);
}

std::size_t GltfBuffers::view(const PackedStream& stream) {
  const bool is_index = stream.attribute.empty();
  const int target = is_index ? kIndices : kVertices;
  const std::size_t stride = is_index ? 0 : stream.stride;
  if (compress_) return packed_view(stream, stride, target);
  return plain_view(stream.bytes.data(), stream.bytes.size(), stride, target);
}

std::size_t GltfBuffers::packed_view(const PackedStream& stream, std::size_t stride, int target) {
  const std::size_t at = put(stream.packed.data(), stream.packed.size());
  const std::size_t unpacked_at = unpacked_size_;
  unpacked_size_ += aligned_to_word(stream.bytes.size());
  return views_.add(fmt::format(
      "{{\"buffer\":1,\"byteOffset\":{},\"byteLength\":{}{},\"target\":{},\"extensions\":{{"
      "\"EXT_meshopt_compression\":{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{},"
      "\"byteStride\":{},\"mode\":\"{}\",\"count\":{}{}}}}}}}",
      unpacked_at,
      stream.bytes.size(),
      stride == 0 ? std::string() : fmt::format(",\"byteStride\":{}", stride),
      target,
      at,
      stream.packed.size(),
      stream.stride,
      stride == 0 ? "TRIANGLES" : "ATTRIBUTES",
      stream.count,
      stream.octahedral ? ",\"filter\":\"OCTAHEDRAL\"" : ""));
}

std::size_t GltfBuffers::plain_view(const void* bytes,
                                    std::size_t size,
                                    std::size_t stride,
                                    int target) {
  std::string text =
      fmt::format("{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}", put(bytes, size), size);
  if (stride > 0) text += fmt::format(",\"byteStride\":{}", stride);
  if (target != kNoTarget) text += fmt::format(",\"target\":{}", target);
  return views_.add(text + '}');
}

std::size_t GltfBuffers::put(const void* bytes, std::size_t size) {
  const std::size_t at = data_.size();
  data_.append(bytes, size);
  data_.append(std::string(aligned_to_word(size) - size, '\0'));
  return at;
}

std::string GltfBuffers::description(const std::string& uri, const std::string& fingerprint) const {
  std::string text = fmt::format("{{\"byteLength\":{}", data_.size());
  if (!uri.empty()) text += ",\"uri\":" + json_quoted(uri);
  if (!fingerprint.empty()) {
    text += fmt::format(",\"extras\":{{\"fingerprint\":{}}}", json_quoted(fingerprint));
  }
  text += '}';
  if (compress_) {
    text += fmt::format(
        ",{{\"byteLength\":{},\"extensions\":{{\"EXT_meshopt_compression\":{{\"fallback\":true}}}"
        "}}}",
        unpacked_size_);
  }
  return text;
}

}  // namespace silvafit::tree
