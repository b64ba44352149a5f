// SPDX-License-Identifier: MIT
// The buffer of a glTF file with the views and accessors into it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "files/packed_part.hpp"
#include "files/spool.hpp"

namespace silvafit::tree {

/// Sizes in a glTF file are multiples of four bytes.
std::size_t aligned_to_word(std::size_t size);

/// The added bytes, and the JSON that describes them.
class GltfBuffers {
 public:
  /// \param beside    the file that will contain the bytes
  /// \param compress  whether streams are compressed (EXT_meshopt_compression)
  GltfBuffers(const std::filesystem::path& beside, bool compress);

  /// The streams of a model; those of the same format share a view.
  /// \returns the indices of their accessors
  std::vector<std::size_t> add_streams(std::span<const PackedStream> streams);
  /// Floats, scalar or in threes.
  /// \param each     1 or 3
  /// \param bounded  with the first and last value as minimum and maximum: times of keyframes
  std::size_t add_floats(const std::vector<float>& values, std::size_t each, bool bounded = false);

  /// Bytes without an accessor, such as an image.
  /// \returns the index of their view
  std::size_t add_view(const std::string& bytes);

  /// Of the buffer itself.
  std::size_t size() const { return data_.size(); }
  Spool& data() { return data_; }
  Spool& views() { return views_.spool(); }
  Spool& accessors() { return accessors_.spool(); }
  /// The items of the array "buffers".
  /// \param uri          of the buffer's own file; empty if it is in the same file
  /// \param fingerprint  of the bytes of that file; empty: not written
  std::string description(const std::string& uri, const std::string& fingerprint) const;

 private:
  std::size_t view(const PackedStream& format, const std::vector<std::uint8_t>& bytes);
  std::size_t plain_view(const void* bytes, std::size_t size, std::size_t stride, int target);
  std::size_t packed_view(const PackedStream& format,
                          const std::vector<std::uint8_t>& bytes,
                          std::size_t stride,
                          int target);
  std::size_t put(const void* bytes, std::size_t size);

  bool compress_;
  Spool data_;
  ArraySpool views_;
  ArraySpool accessors_;
  std::size_t unpacked_size_ = 0;  ///< of the compressed streams
};

}  // namespace silvafit::tree
