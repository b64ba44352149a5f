// SPDX-License-Identifier: MIT
// A short mark by which to tell that a file is the same.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::study {

/// "fnv1a64:" and sixteen hexadecimal digits. Tells files apart by accident, not against intent.
/// Source: Fowler, Noll and Vo, FNV-1a with 64 bits (IETF draft-eastlake-fnv).
std::string fingerprint(std::string_view bytes);

}  // namespace silvafit::study
