// SPDX-License-Identifier: MIT
// Pictures from PNG files.
#pragma once

#include <filesystem>

#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

/// A picture with any number of pixels to a side; one without opacity is opaque.
/// \throws InputError if it cannot be read, or has more than 4096 pixels to a side; UsageError if
/// the library was built without libpng
Texture read_png(const std::filesystem::path& file);

}  // namespace silvafit::tree
