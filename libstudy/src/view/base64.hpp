// SPDX-License-Identifier: MIT
// Bytes as text.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::study {

/// Base64 with padding. Source: RFC 4648, section 4.
std::string base64(std::string_view bytes);

}  // namespace silvafit::study
