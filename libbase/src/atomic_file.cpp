// SPDX-License-Identifier: MIT
#include "silvafit/base/atomic_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <ostream>
#include <set>
#include <streambuf>
#include <string>
#include <system_error>
#include <utility>

#include "silvafit/base/built_in_files.hpp"
#include "silvafit/base/io_error.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/base/system.hpp"
#include "unfinished_files.hpp"

namespace silvafit {
namespace {

/// Closes a descriptor at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  /// \return whether the system closed it without an error
  bool close();

 private:
  int number_;
};

/// Writes to a descriptor that the caller opens and closes. Unlike std::ofstream it keeps the
/// reason of the first failure.
class DescriptorBuffer final : public std::streambuf {
 public:
  explicit DescriptorBuffer(int descriptor);

  /// errno of the first write that failed; 0 if none failed.
  int error_number() const { return error_number_; }

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* bytes, std::streamsize count) override;
  int sync() override;

 private:
  bool write_buffered();
  bool write_all(const char* bytes, std::size_t count);

  static constexpr std::size_t kBlock = std::size_t{1} << 16U;
  int descriptor_;
  int error_number_ = 0;
  std::array<char, kBlock> block_{};
};

bool Descriptor::close() {
  const int number = std::exchange(number_, -1);
  return number < 0 || system::close(number);
}

DescriptorBuffer::DescriptorBuffer(int descriptor) : descriptor_(descriptor) {
  setp(block_.data(), block_.data() + block_.size());
}

bool DescriptorBuffer::write_all(const char* bytes, std::size_t count) {
  while (count > 0 && error_number_ == 0) {
    const std::ptrdiff_t written = system::write(descriptor_, bytes, count);
    if (written >= 0) {
      bytes += written;
      count -= static_cast<std::size_t>(written);
    } else {
      error_number_ = errno;
    }
  }
  return error_number_ == 0;
}

bool DescriptorBuffer::write_buffered() {
  const auto count = static_cast<std::size_t>(pptr() - pbase());
  setp(block_.data(), block_.data() + block_.size());
  return write_all(block_.data(), count);
}

std::streambuf::int_type DescriptorBuffer::overflow(int_type c) {
  if (!write_buffered()) return traits_type::eof();
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  return sputc(traits_type::to_char_type(c));
}

std::streamsize DescriptorBuffer::xsputn(const char* bytes, std::streamsize count) {
  if (count <= epptr() - pptr()) {
    std::memcpy(pptr(), bytes, static_cast<std::size_t>(count));
    pbump(static_cast<int>(count));
    return count;
  }
  const bool is_written = write_buffered() && write_all(bytes, static_cast<std::size_t>(count));
  return is_written ? count : 0;
}

int DescriptorBuffer::sync() { return write_buffered() ? 0 : -1; }

namespace fs = std::filesystem;

std::string reason(const char* verb, int error_number) {
  return fmt::format("cannot {} ({})", verb, system::reason(error_number));
}

[[noreturn]] void cannot(const char* verb, const fs::path& path, int error_number) {
  throw IoError(reason(verb, error_number), {.file = path.string()});
}

[[noreturn]] void cannot(const char* verb, const fs::path& path, const std::error_code& error) {
  // Systems have numbers of their own for errors of folders.
  cannot(verb, path, error.default_error_condition().value());
}

/// Whether bytes go directly to the target, because there is no file to replace: devices, pipes,
/// and names of open files such as /dev/stdout.
bool is_stream(const fs::path& target) {
  const fs::path name = target.lexically_normal();
  if (name == "/dev/stdout" || name == "/dev/stderr" || name.parent_path() == "/dev/fd")
    return true;
  std::error_code ignored;
  const fs::file_status status = fs::status(target, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// The file that a symbolic link names, whether or not it exists.
fs::path behind_links(const fs::path& target) {
  constexpr int kMostLinks = 40;  // the limit of Linux
  fs::path path = target;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code error;
    if (fs::symlink_status(path, error).type() != fs::file_type::symlink) return path;
    const fs::path link = fs::read_symlink(path, error);
    if (error) cannot("write", target, error);
    path = path.parent_path() / link;
  }
  cannot("write", target, ELOOP);
}

/// The permissions of an existing file; none if there is no file.
std::optional<fs::perms> permissions_of(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) return std::nullopt;
  return status.permissions() & fs::perms::all;
}

}  // namespace

struct AtomicFile::State {
  fs::path named;                   ///< as the caller gave it
  fs::path target;                  ///< behind symbolic links
  fs::path temporary{};             ///< empty: bytes go directly to the target
  std::vector<fs::path> folders{};  ///< created for it
  Descriptor descriptor;
  DescriptorBuffer buffer;
  std::ostream stream;
  bool has_name = false;

  State(fs::path name, fs::path file, UnfinishedFiles::Opened opened)
      : named(std::move(name)),
        target(std::move(file)),
        temporary(std::move(opened.path)),
        descriptor(opened.descriptor),
        buffer(opened.descriptor),
        stream(&buffer) {}

  ~State() {
    if (has_name || temporary.empty()) return;
    descriptor.close();  // an open file keeps its name on some systems
    std::error_code ignored;
    fs::remove(temporary, ignored);
    UnfinishedFiles::of_process().forget(temporary);
    remove_empty(folders);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  /// Writes all bytes and waits until they are on the disk.
  void finish() {
    stream.flush();
    if (!stream) cannot("write", named, buffer.error_number() != 0 ? buffer.error_number() : EIO);
    if (!temporary.empty() && !system::flush_to_disk(descriptor.number()))
      cannot("write", named, errno);
    if (!descriptor.close()) cannot("write", named, errno);
  }

  void give_name() {
    std::error_code error;
    if (!temporary.empty()) fs::rename(temporary, target, error);
    if (error) cannot("write", named, error);
    has_name = true;
  }
};

AtomicFile::AtomicFile(const fs::path& wanted) {
  // All ranks of a job compute the same results; the first one writes them.
  const fs::path target = Ranks::of_process().is_first() ? wanted : fs::path("/dev/null");
  if (is_stream(target)) {
    // Append to what the target already contains.
    const int descriptor = system::open_to_append(target);
    if (descriptor < 0) cannot("write", target, errno);
    state_ =
        std::make_unique<State>(target, target, UnfinishedFiles::Opened{.descriptor = descriptor});
    return;
  }
  const fs::path file = behind_links(target);
  std::vector<fs::path> folders;
  if (file.has_parent_path()) {
    const std::error_code error =
        UnfinishedFiles::of_process().make_folders(file.parent_path(), folders);
    if (error) {
      remove_empty(folders);
      cannot("make the folder", file.parent_path(), error);
    }
  }
  constexpr auto kOfNewFiles = fs::perms{0666};
  const std::optional<fs::perms> permissions = permissions_of(file);
  const UnfinishedFiles::Opened opened =
      UnfinishedFiles::of_process().make_file(file, permissions.value_or(kOfNewFiles));
  if (opened.descriptor < 0) {
    const int error_number = errno;
    remove_empty(folders);
    cannot("write", target, error_number);
  }
  state_ = std::make_unique<State>(target, file, opened);
  state_->folders = std::move(folders);
  if (permissions && !system::set_permissions(opened.descriptor, *permissions)) {
    cannot("write", target, errno);
  }
}

AtomicFile::~AtomicFile() = default;

std::ostream& AtomicFile::stream() { return state_->stream; }

void AtomicFile::commit() { commit_together({this}); }

void commit_together(const std::vector<AtomicFile*>& files) {
  for (const AtomicFile* file : files) file->state_->finish();
  UnfinishedFiles& unfinished = UnfinishedFiles::of_process();
  unfinished.undivided([&files] {
    for (const AtomicFile* file : files) file->state_->give_name();
  });
  std::set<fs::path> folders;
  for (const AtomicFile* file : files) {
    const AtomicFile::State& state = *file->state_;
    if (state.temporary.empty()) continue;
    unfinished.forget(state.temporary);
    const bool is_new = folders.insert(state.target.parent_path()).second;
    const fs::path folder = state.target.has_parent_path() ? state.target.parent_path() : ".";
    if (is_new && !system::flush_folder(folder)) cannot("write", state.named, errno);
  }
}

void write_file(const fs::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.commit();
}

void require_writable_folder(const fs::path& folder) { const AtomicFile probe(folder / "probe"); }

ResultFolder::ResultFolder(const fs::path& path) {
  if (!Ranks::of_process().is_first()) return;
  const std::error_code error = UnfinishedFiles::of_process().make_folders(path, made_);
  try {
    if (error) cannot("make the folder", path, error);
    if (!system::lock_folder(path, lock_)) {
      throw IoError(
          "another silvafit is writing into this folder; wait until it has ended, or choose "
          "another folder",
          {.file = path.string()});
    }
    require_writable_folder(path);
  } catch (...) {
    remove_empty(made_);
    throw;
  }
}

ResultFolder::~ResultFolder() { remove_empty(made_); }

TemporaryFolder::TemporaryFolder(std::string_view name) {
  std::error_code error;
  const fs::path all = fs::temp_directory_path(error);
  if (error) cannot("use the folder for temporary files", all, error);
  path_ = UnfinishedFiles::of_process().make_temporary_folder(all / name);
  if (path_.empty()) cannot("make the folder", all / name, errno);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  UnfinishedFiles::of_process().forget(path_);
}

void discard_unfinished_files() { UnfinishedFiles::of_process().discard(); }

NamelessFile open_nameless_file(const fs::path& beside) {
  std::vector<fs::path> folders;
  std::error_code ignored;  // opening the file reports the error
  const bool has_folder = !is_stream(beside);
  const fs::path place = has_folder ? beside : fs::temp_directory_path(ignored) / "silvafit";
  UnfinishedFiles& unfinished = UnfinishedFiles::of_process();
  if (has_folder && beside.has_parent_path()) {
    ignored = unfinished.make_folders(beside.parent_path(), folders);
  }
  NamelessFile file(unfinished.make_nameless_file(place));
  if (file) return file;
  const int error_number = errno;
  remove_empty(folders);
  cannot("write", beside, error_number);
}

std::string read_file(const fs::path& path, std::uint64_t limit) {
  const auto built_in = built_in_files().find(path);
  if (built_in != built_in_files().end()) return std::string(built_in->second);
  const auto refuse = [&path](int error_number) {
    throw InputError(reason("read", error_number), {.file = path.string()});
  };
  const auto refuse_size = [&path](std::uint64_t most) {
    constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20U;
    throw InputError(fmt::format("is larger than {} MiB, the limit for files of this kind; check "
                                 "that it is the right file",
                                 (most + kMebibyte - 1) / kMebibyte),
                     {.file = path.string()});
  };
  const Descriptor opened(system::open_to_read(path));
  if (opened.number() < 0) refuse(errno);
  std::string bytes;
  const std::optional<std::uint64_t> size = system::file_size(opened.number());
  if (!size) limit = std::min(limit, kLargestFile);
  if (size.value_or(0) > limit) refuse_size(limit);
  bytes.reserve(static_cast<std::size_t>(size.value_or(0)));
  constexpr std::size_t kBlock = std::size_t{1} << 16U;
  std::array<char, kBlock> block{};
  while (true) {
    const std::ptrdiff_t count = system::read(opened.number(), block.data(), block.size());
    if (count > 0) {
      bytes.append(block.data(), static_cast<std::size_t>(count));
      if (bytes.size() > limit) refuse_size(limit);
    } else if (count == 0) {
      return bytes;
    } else if (errno == EISDIR) {
      refuse(EISDIR);
    } else {
      cannot("read", path, errno);
    }
  }
}

}  // namespace silvafit
