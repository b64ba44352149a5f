// SPDX-License-Identifier: MIT
// A target as libFuzzer calls it.
#include <cstddef>
#include <cstdint>

#include "fuzz_target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  silvafit::fuzz::read_checked({reinterpret_cast<const char*>(data), size});
  return 0;
}
