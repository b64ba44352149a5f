// SPDX-License-Identifier: MIT
// The buffer of a glTF file with the views and accessors into it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "files/json_spool.hpp"
#include "files/packed_part.hpp"
#include "files/spool.hpp"

namespace silvafit::tree {

/// Sizes in a glTF file go by four bytes.
std::size_t aligned_to_word(std::size_t size);

/// Bytes as they are added, and the JSON that says what they are.
class GltfBuffers {
 public:
  /// \param beside    the file that will take the bytes; empty keeps all in memory
  /// \param compress  whether streams are written as packed (EXT_meshopt_compression)
  GltfBuffers(const std::filesystem::path& beside, bool compress);

  /// Each returns the number of the accessor that was added.
  std::size_t add_attribute(const PackedStream& stream);
  /// With the least and most of the positions, which glTF asks for.
  std::size_t add_positions(const PackedStream& stream, const PackedPart& bounds);
  std::size_t add_indices(const PackedStream& stream);
  /// Floats by ones or threes.
  /// \param each     1 or 3
  /// \param bounded  with the first and last value as least and most: times of keyframes
  std::size_t add_floats(const std::vector<float>& values, std::size_t each, bool bounded = false);

  /// Bytes that no accessor reads, such as a picture's.
  /// \returns the number of their view
  std::size_t add_view(const std::string& bytes);

  /// Of the buffer itself.
  std::size_t size() const { return data_.size(); }
  Spool& data() { return data_; }
  Spool& views() { return views_.spool(); }
  Spool& accessors() { return accessors_.spool(); }
  /// The items of the array "buffers".
  /// \param uri  of the buffer's own file; empty where it is in the same
  std::string description(const std::string& uri) const;

 private:
  std::size_t add_stream(const PackedStream& stream, const std::string& more);
  std::size_t view(const PackedStream& stream);
  std::size_t plain_view(const void* bytes, std::size_t size, std::size_t stride, int target);
  std::size_t packed_view(const PackedStream& stream, std::size_t stride, int target);
  std::size_t put(const void* bytes, std::size_t size);

  bool compress_;
  Spool data_;
  ArraySpool views_;
  ArraySpool accessors_;
  std::size_t unpacked_size_ = 0;  ///< of the streams that are packed
};

}  // namespace silvafit::tree
