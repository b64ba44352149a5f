// SPDX-License-Identifier: MIT
// The parts of a workbook, which is a ZIP archive, by libzip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

struct zip;

namespace silvafit::source {

struct CloseArchive {
  void operator()(zip* archive) const;
};
using ZipArchive = std::unique_ptr<zip, CloseArchive>;

class Archive {
 public:
  /// \param bytes   of the file; must outlive this object
  /// \param format  for messages: "an Excel workbook"
  /// \throws InputError if it is no archive, two parts have one name, or it unpacks to more than
  ///   64 MiB and 256 times its size
  Archive(std::string_view bytes, std::string format, std::string file);

  bool has(std::string_view part) const { return find(part) != nullptr; }

  /// Unpacks a part block by block.
  /// \throws InputError that names the part if it is missing or damaged, by length or checksum
  void read(std::string_view part, const std::function<void(std::string_view)>& take);

  /// Checks the parts that were not read, so that no damage passes unnoticed.
  void check_unread_parts();

  /// Of all parts when unpacked.
  std::uint64_t unpacked_bytes() const { return unpacked_bytes_; }
  const std::string& file() const { return file_; }
  /// \throws InputError "the workbook is damaged: ..."
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  struct Part {
    std::string name{};
    std::uint64_t index = 0;
    std::uint64_t bytes = 0;
    bool is_read = false;
  };
  const Part* find(std::string_view name) const;
  void list_parts();
  void unpack(Part& part, const std::function<void(std::string_view)>& take);

  std::string file_;
  ZipArchive zip_{};
  std::vector<Part> parts_{};  // by name
  std::uint64_t unpacked_bytes_ = 0;
};

/// The names and texts of parts, in the order of an archive.
using ArchiveParts = std::vector<std::pair<std::string, std::string>>;

/// The bytes of an archive, which depend on its parts only.
std::string packed(const ArchiveParts& parts);

}  // namespace silvafit::source
