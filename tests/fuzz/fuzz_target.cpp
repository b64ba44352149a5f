// SPDX-License-Identifier: MIT
#include "fuzz_target.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "silvafit/base/error.hpp"

namespace silvafit::fuzz {

void read_checked(std::string_view bytes) {
  try {
    read(bytes);
  } catch (const Error& error) {
    if (!error.message().empty()) return;
    std::fputs("an error without a message\n", stderr);
    std::abort();
  }
}

FileOfBytes::FileOfBytes(std::string_view bytes) : descriptor_(memfd_create("silvafit-fuzz", 0)) {
  if (descriptor_ < 0) throw std::runtime_error("no file in memory can be made");
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written <= 0) throw std::runtime_error("a file in memory cannot be written");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

FileOfBytes::~FileOfBytes() { close(descriptor_); }

std::filesystem::path FileOfBytes::path() const {
  return "/proc/self/fd/" + std::to_string(descriptor_);
}

}  // namespace silvafit::fuzz
