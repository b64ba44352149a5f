// SPDX-License-Identifier: MIT
#include "standard_streams.hpp"

#include <cstdio>

namespace silvafit::cli {

void write_to_standard_error(std::string_view text) noexcept {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace silvafit::cli
