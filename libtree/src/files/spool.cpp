// SPDX-License-Identifier: MIT
#include "files/spool.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "silvafit/base/io_error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/system.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kInMemory = std::size_t{4} << 20U;

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw IoError(fmt::format("cannot write ({})", system::reason(errno)), {.file = path.string()});
}

}  // namespace

Spool::Spool(std::filesystem::path beside) : beside_(std::move(beside)) {}

void Spool::append(std::string_view bytes) {
  size_ += bytes.size();
  memory_.append(bytes);
  if (memory_.size() >= kInMemory) spill();
}

void Spool::append(const void* data, std::size_t size) {
  append(std::string_view(static_cast<const char*>(data), size));
}

void Spool::spill() {
  if (!file_) file_ = open_nameless_file(beside_);
  if (std::fwrite(memory_.data(), 1, memory_.size(), file_.get()) != memory_.size()) fail(beside_);
  memory_.clear();
}

void Spool::read(const std::function<void(std::string_view)>& take) {
  if (file_) {
    std::rewind(file_.get());
    std::vector<char> block(std::size_t{1} << 20U);
    for (std::size_t left = size_ - memory_.size(); left > 0;) {
      const std::size_t got =
          std::fread(block.data(), 1, std::min(block.size(), left), file_.get());
      if (got == 0) fail(beside_);
      take({block.data(), got});
      left -= got;
    }
  }
  take(memory_);
}

void Spool::copy_to(std::ostream& to) {
  read([&to](std::string_view bytes) {
    to.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  });
}

std::string json_quoted(const std::string& text) { return json_text(nlohmann::json(text)); }

std::string json_triple(const std::array<double, 3>& values) {
  return fmt::format("[{},{},{}]", values[0], values[1], values[2]);
}

std::size_t ArraySpool::add(const std::string& item) {
  if (count_ > 0) spool_.append(",");
  spool_.append(item);
  return count_++;
}

std::size_t Pieces::size() const {
  std::size_t sum = 0;
  for (const auto& [text, spool] : pieces_) sum += spool != nullptr ? spool->size() : text.size();
  return sum;
}

void Pieces::write_to(std::ostream& to) const {
  for (const auto& [text, spool] : pieces_) {
    if (spool != nullptr) {
      spool->copy_to(to);
    } else {
      to << text;
    }
  }
}

}  // namespace silvafit::tree
