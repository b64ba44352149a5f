// SPDX-License-Identifier: MIT
#include "files/glb_container.hpp"

#include <cstdint>
#include <cstring>

#include "files/gltf_document.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kHeader = 12;
constexpr std::size_t kPartHeader = 8;
constexpr std::size_t kDescription = kHeader + kPartHeader;

std::size_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

std::string word(std::size_t value) {
  std::string bytes(4, '\0');
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<char>(value >> (8 * i) & 0xFFU);
  return bytes;
}

}  // namespace

GlbParts glb_parts(std::string_view bytes) {
  if (bytes.size() < kDescription || bytes.substr(0, 4) != "glTF")
    refuse_gltf("it does not begin with 'glTF'");
  if (word_at(bytes, 4) != 2) refuse_gltf("its version is not 2");
  if (word_at(bytes, 8) != bytes.size())
    refuse_gltf("its length differs from the length in its header");
  const std::size_t length = word_at(bytes, kHeader);
  if (bytes.substr(16, 4) != "JSON" || length > bytes.size() - kDescription)
    refuse_gltf("it has no JSON part");
  GlbParts parts{.description = gltf_description(bytes.substr(kDescription, length))};
  const std::size_t buffer = kDescription + length + kPartHeader;
  if (buffer <= bytes.size()) {
    const std::size_t size = word_at(bytes, kDescription + length);
    if (size > bytes.size() - buffer) refuse_gltf("its binary buffer is truncated");
    parts.buffer = bytes.substr(buffer, size);
  }
  return parts;
}

nlohmann::json gltf_description(std::string_view text) {
  nlohmann::json description = nlohmann::json::parse(text, nullptr, false);
  if (!description.is_object()) refuse_gltf("its JSON part is not valid JSON");
  return description;
}

std::size_t glb_size(std::size_t description, std::size_t buffer) {
  return kDescription + description + kPartHeader + buffer;
}

std::string glb_head(std::size_t description, std::size_t buffer) {
  return "glTF" + word(2) + word(glb_size(description, buffer)) + word(description) + "JSON";
}

std::string glb_buffer_head(std::size_t buffer) { return word(buffer) + std::string("BIN\0", 4); }

}  // namespace silvafit::tree
