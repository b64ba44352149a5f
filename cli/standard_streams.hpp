// SPDX-License-Identifier: MIT
// Notes on standard error.
#pragma once

#include <string_view>

namespace silvafit::cli {

/// Writes a text unchanged. A failure is ignored: it does not stop the work or change the exit
/// status.
void write_to_standard_error(std::string_view text) noexcept;

}  // namespace silvafit::cli
