// SPDX-License-Identifier: MIT
#include "library/fingerprint.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace silvafit::study {

std::string fingerprint(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char byte : bytes) {
    hash ^= static_cast<unsigned char>(byte);
    hash *= 0x100000001b3U;
  }
  return fmt::format("fnv1a64:{:016x}", hash);
}

}  // namespace silvafit::study
