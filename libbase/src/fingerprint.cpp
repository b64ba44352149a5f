// SPDX-License-Identifier: MIT
#include "silvafit/base/fingerprint.hpp"

#include <fmt/format.h>

namespace silvafit {

void Fingerprint::add(std::string_view bytes) {
  constexpr std::uint64_t kPrime = 0x100000001b3U;
  for (const char byte : bytes) {
    hash_ ^= static_cast<unsigned char>(byte);
    hash_ *= kPrime;
  }
}

std::string Fingerprint::text() const { return fmt::format("fnv1a64:{:016x}", hash_); }

std::string fingerprint(std::string_view bytes) {
  Fingerprint whole;
  whole.add(bytes);
  return whole.text();
}

}  // namespace silvafit
