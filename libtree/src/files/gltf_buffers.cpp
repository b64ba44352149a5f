// SPDX-License-Identifier: MIT
#include "files/gltf_buffers.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace silvafit::tree {
namespace {

constexpr std::size_t kAlignment = 4;

/// glTF's target constants of a buffer view; 0 for none.
constexpr int kNoTarget = 0;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

std::string accessor_text(const PackedStream& stream, std::size_t view, std::size_t start) {
  static constexpr std::array<const char*, 5> kTypes{"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  std::string text = fmt::format("{{\"bufferView\":{}", view);
  if (start > 0) text += fmt::format(",\"byteOffset\":{}", start);
  text += fmt::format(",\"componentType\":{},\"count\":{},\"type\":\"{}\"",
                      static_cast<int>(stream.component),
                      stream.count,
                      kTypes.at(static_cast<std::size_t>(stream.components)));
  if (stream.normalized) text += ",\"normalized\":true";
  if (stream.bounds) {
    text += fmt::format(",\"min\":{},\"max\":{}",
                        json_triple(stream.bounds->least),
                        json_triple(stream.bounds->most));
  }
  return text + '}';
}

}  // namespace

std::size_t aligned_to_word(std::size_t size) {
  return (size + kAlignment - 1) / kAlignment * kAlignment;
}

GltfBuffers::GltfBuffers(const std::filesystem::path& beside, bool compress)
    : compress_(compress), data_(beside), views_(beside), accessors_(beside) {}

std::vector<std::size_t> GltfBuffers::add_streams(std::span<const PackedStream> streams) {
  std::vector<std::size_t> accessors(streams.size());
  std::vector<bool> is_added(streams.size(), false);
  for (std::size_t first = 0; first < streams.size(); ++first) {
    if (is_added[first]) continue;
    const PackedStream& format = streams[first];
    std::vector<std::uint8_t> bytes;
    std::vector<std::pair<std::size_t, std::size_t>> starts;  // of streams, in the view
    for (std::size_t i = first; i < streams.size(); ++i) {
      if (!streams[i].has_format_of(format)) continue;
      starts.emplace_back(i, bytes.size());
      bytes.insert(bytes.end(), streams[i].bytes.begin(), streams[i].bytes.end());
      is_added[i] = true;
    }
    const std::size_t in_view = view(format, bytes);
    for (const auto& [stream, start] : starts) {
      accessors[stream] = accessors_.add(accessor_text(streams[stream], in_view, start));
    }
  }
  return accessors;
}

std::size_t GltfBuffers::add_floats(const std::vector<float>& values,
                                    std::size_t each,
                                    bool bounded) {
  const PackedStream stream{.components = static_cast<int>(each), .count = values.size() / each};
  const std::size_t in_view =
      plain_view(values.data(), values.size() * sizeof(float), 0, kNoTarget);
  std::string text = accessor_text(stream, in_view, 0);
  if (bounded) {
    text.back() = ',';
    text += fmt::format("\"min\":[{}],\"max\":[{}]}}", values.front(), values.back());
  }
  return accessors_.add(text);
}

std::size_t GltfBuffers::add_view(const std::string& bytes) {
  return plain_view(bytes.data(), bytes.size(), 0, kNoTarget);
}

std::size_t GltfBuffers::view(const PackedStream& format, const std::vector<std::uint8_t>& bytes) {
  const bool is_index = format.attribute.empty();
  const int target = is_index ? kElementArrayBuffer : kArrayBuffer;
  const std::size_t stride = is_index ? 0 : format.stride;
  if (compress_) return packed_view(format, bytes, stride, target);
  return plain_view(bytes.data(), bytes.size(), stride, target);
}

std::size_t GltfBuffers::packed_view(const PackedStream& format,
                                     const std::vector<std::uint8_t>& bytes,
                                     std::size_t stride,
                                     int target) {
  const std::vector<std::uint8_t> packed = compressed(format, bytes);
  const std::size_t at = put(packed.data(), packed.size());
  const std::size_t unpacked_at = unpacked_size_;
  unpacked_size_ += aligned_to_word(bytes.size());
  return views_.add(fmt::format(
      "{{\"buffer\":1,\"byteOffset\":{},\"byteLength\":{}{},\"target\":{},\"extensions\":{{"
      "\"EXT_meshopt_compression\":{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{},"
      "\"byteStride\":{},\"mode\":\"{}\",\"count\":{}{}}}}}}}",
      unpacked_at,
      bytes.size(),
      stride == 0 ? std::string() : fmt::format(",\"byteStride\":{}", stride),
      target,
      at,
      packed.size(),
      format.stride,
      stride == 0 ? "TRIANGLES" : "ATTRIBUTES",
      bytes.size() / format.stride,
      format.octahedral ? ",\"filter\":\"OCTAHEDRAL\"" : ""));
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
