// SPDX-License-Identifier: MIT
#include "workbook/archive.hpp"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <new>
#include <utility>

#include "silvafit/base/error.hpp"

namespace silvafit::source {
namespace {

struct CloseZipFile {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

struct FreeSource {
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};

ZipArchive open_archive(std::string_view bytes) {
  zip_source_t* const source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, nullptr);
  if (source == nullptr) return nullptr;
  ZipArchive archive(zip_open_from_source(source, ZIP_RDONLY, nullptr));
  if (!archive) zip_source_free(source);
  return archive;
}

/// The parts of real workbooks have up to about 50 times the bytes of their archive; those of zeros
/// have 1000 times as many.
void require_bounded(std::uint64_t size, std::uint64_t unpacked, const std::string& file) {
  constexpr std::uint64_t kFree = std::uint64_t{64} << 20U;
  constexpr std::uint64_t kMostRatio = 256;
  if (unpacked <= kFree || unpacked / kMostRatio <= size) return;
  throw InputError(
      fmt::format("the workbook of {} bytes unpacks to {} bytes, more than {} times as "
                  "many; save its sheets as CSV in UTF-8",
                  size,
                  unpacked,
                  kMostRatio),
      {.file = file});
}

}  // namespace

void CloseArchive::operator()(zip* archive) const { zip_discard(archive); }

Archive::Archive(std::string_view bytes, std::string format, std::string file)
    : file_(std::move(file)), zip_(open_archive(bytes)) {
  if (!zip_) {
    throw InputError(fmt::format("is not {}, or is damaged; open it in the program that made it "
                                 "and save it again",
                                 format),
                     {.file = file_});
  }
  list_parts();
  require_bounded(bytes.size(), unpacked_bytes_, file_);
}

void Archive::refuse(const std::string& what) const {
  throw InputError(
      fmt::format("the workbook is damaged: {}; restore it, or open it in the program that made it "
                  "and save it again",
                  what),
      {.file = file_});
}

void Archive::list_parts() {
  constexpr std::uint64_t kLargestPart = std::uint64_t{1} << 40U;  // sums cannot overflow
  const auto count = static_cast<std::uint64_t>(zip_get_num_entries(zip_.get(), 0));
  for (std::uint64_t i = 0; i < count; ++i) {
    zip_stat_t status{};
    if (zip_stat_index(zip_.get(), i, 0, &status) != 0 || status.name == nullptr) {
      refuse("its list of parts cannot be read");
    }
    const std::string name = status.name;
    const bool is_usual =
        status.comp_method == ZIP_CM_STORE || status.comp_method == ZIP_CM_DEFLATE;
    if (!is_usual || status.encryption_method != ZIP_EM_NONE) {
      refuse(fmt::format("{} is encrypted, or packed in a way that workbooks do not use", name));
    }
    parts_.push_back({.name = name, .index = i, .bytes = std::min(status.size, kLargestPart)});
    unpacked_bytes_ += parts_.back().bytes;
  }
  std::ranges::sort(parts_, {}, &Part::name);
  const auto twice = std::ranges::adjacent_find(parts_, {}, &Part::name);
  if (twice != parts_.end()) refuse(fmt::format("it has two parts {}", twice->name));
}

const Archive::Part* Archive::find(std::string_view name) const {
  const auto found = std::ranges::lower_bound(parts_, name, {}, &Part::name);
  return found != parts_.end() && found->name == name ? &*found : nullptr;
}

void Archive::read(std::string_view part, const std::function<void(std::string_view)>& take) {
  const Part* const found = find(part);
  if (found == nullptr) refuse(fmt::format("its part {} is missing", part));
  unpack(parts_[static_cast<std::size_t>(found - parts_.data())], take);
}

void Archive::unpack(Part& part, const std::function<void(std::string_view)>& take) {
  const auto fail = [&] { refuse(fmt::format("{} cannot be read", part.name)); };
  const std::unique_ptr<zip_file_t, CloseZipFile> file(zip_fopen_index(zip_.get(), part.index, 0));
  if (!file) fail();
  std::vector<char> block(std::size_t{1} << 16U);
  std::uint64_t total = 0;
  for (;;) {
    // At the end libzip compares the checksum.
    const zip_int64_t count = zip_fread(file.get(), block.data(), block.size());
    if (count == 0) break;
    if (count > 0) total += static_cast<std::uint64_t>(count);
    if (count < 0 || total > part.bytes) fail();
    take({block.data(), static_cast<std::size_t>(count)});
  }
  if (total != part.bytes) fail();
  part.is_read = true;
}

void Archive::check_unread_parts() {
  for (Part& part : parts_) {
    if (!part.is_read) unpack(part, [](std::string_view /*block*/) {});
  }
}

std::string packed(const ArchiveParts& parts) {
  // Nothing but memory can be missing.
  const auto require = [](bool is_done) {
    if (!is_done) throw std::bad_alloc();
  };
  const std::unique_ptr<zip_source_t, FreeSource> target(
      zip_source_buffer_create(nullptr, 0, 0, nullptr));
  require(target != nullptr);
  ZipArchive archive(zip_open_from_source(target.get(), ZIP_CREATE | ZIP_TRUNCATE, nullptr));
  require(archive != nullptr);
  // The archive frees it, too.
  zip_source_keep(target.get());
  for (const auto& [name, text] : parts) {
    zip_source_t* const source = zip_source_buffer(archive.get(), text.data(), text.size(), 0);
    require(source != nullptr);
    const zip_int64_t index = zip_file_add(archive.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) zip_source_free(source);
    require(index >= 0);
    const auto part = static_cast<zip_uint64_t>(index);
    // Files of the same content have the same bytes: 1 January 1980, the first day of ZIP.
    constexpr zip_uint16_t kFirstDay = (1U << 5U) + 1U;
    require(zip_file_set_dostime(archive.get(), part, 0, kFirstDay, 0) == 0);
    // OpenDocument asks for an unpacked first part, by which its files are recognized. Others get
    // the usual level: libzip's own, 9, takes three times as long for 3 % fewer bytes.
    constexpr zip_uint32_t kLevel = 6;
    const bool is_packed = name != "mimetype";
    require(zip_set_file_compression(archive.get(),
                                     part,
                                     is_packed ? ZIP_CM_DEFLATE : ZIP_CM_STORE,
                                     is_packed ? kLevel : 0) == 0);
  }
  require(zip_close(archive.get()) == 0);
  static_cast<void>(archive.release());
  zip_stat_t status{};
  require(zip_source_open(target.get()) == 0 && zip_source_stat(target.get(), &status) == 0);
  std::string bytes(static_cast<std::size_t>(status.size), '\0');
  const zip_int64_t count = zip_source_read(target.get(), bytes.data(), bytes.size());
  zip_source_close(target.get());
  require(count == static_cast<zip_int64_t>(bytes.size()));
  return bytes;
}

}  // namespace silvafit::source
