// SPDX-License-Identifier: MIT
// The kinds of errors, from which R and Python make classes.
#pragma once

#include <string_view>

#include "silvafit/base/error.hpp"

namespace silvafit::study {

/// "formula", "usage", "domain", "input", "numerical", "geometry" or "io"; else "other".
std::string_view error_kind(const Error& error);

}  // namespace silvafit::study
