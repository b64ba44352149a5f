// SPDX-License-Identifier: MIT
#include "files/spool.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kInMemory = std::size_t{4} << 20U;

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw InputError(fmt::format("cannot write ({})", std::strerror(errno)), {.file = path.string()});
}

}  // namespace

Spool::Spool(std::filesystem::path beside) : beside_(std::move(beside)) {}

void Spool::append(std::string_view bytes) {
  size_ += bytes.size();
  memory_.append(bytes);
  if (memory_.size() >= kInMemory && !beside_.empty()) spill();
}

void Spool::append(const void* data, std::size_t size) {
  append(std::string_view(static_cast<const char*>(data), size));
}

void Spool::spill() {
  if (!file_) {
    static std::atomic<unsigned> counter{0};
    const std::string name = fmt::format("{}.{}.{}.spool", beside_.string(), ::getpid(), counter++);
    if (beside_.has_parent_path()) {
      std::error_code ignored;  // opening gives the reason of an error
      std::filesystem::create_directories(beside_.parent_path(), ignored);
    }
    file_.reset(std::fopen(name.c_str(), "w+bx"));
    if (!file_) fail(beside_);
    std::error_code ignored;
    std::filesystem::remove(name, ignored);
  }
  if (std::fwrite(memory_.data(), 1, memory_.size(), file_.get()) != memory_.size()) fail(beside_);
  memory_.clear();
}

void Spool::copy_to(std::ostream& to) {
  if (file_) {
    std::rewind(file_.get());
    std::vector<char> block(std::size_t{1} << 20U);
    for (std::size_t left = size_ - memory_.size(); left > 0;) {
      const std::size_t got =
          std::fread(block.data(), 1, std::min(block.size(), left), file_.get());
      if (got == 0) fail(beside_);
      to.write(block.data(), static_cast<std::streamsize>(got));
      left -= got;
    }
  }
  to.write(memory_.data(), static_cast<std::streamsize>(memory_.size()));
}

}  // namespace silvafit::tree
