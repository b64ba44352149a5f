// SPDX-License-Identifier: MIT
// Closed standard streams, and notes on standard error.
#pragma once

#include <string_view>

namespace silvafit::cli {

/// Opens closed standard streams such that reading and writing them fails. Otherwise the next
/// opened file would get their number, and notes would be written into results. Call it first.
void occupy_closed_streams();

/// Writes a text unchanged. A failure is ignored: it does not stop the work or change the exit
/// status.
void write_to_standard_error(std::string_view text) noexcept;

}  // namespace silvafit::cli
