// SPDX-License-Identifier: MIT
// The streams that the shell hands over: those that are closed, and notes on standard error.
#pragma once

#include <string_view>

namespace silvafit::cli {

/// Opens those of the three standard streams that are closed, such that reading and writing them
/// fails. Otherwise the next file to be opened would take their place, and notes would go into
/// results. To be called first.
void occupy_closed_streams();

/// Writes a text as it is. What cannot be written is lost: a note that nobody reads is no reason to
/// stop the work or to change its exit status.
void write_to_standard_error(std::string_view text) noexcept;

}  // namespace silvafit::cli
