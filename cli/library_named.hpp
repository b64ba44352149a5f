// SPDX-License-Identifier: MIT
// Model libraries named on the command line.
#pragma once

#include <string>

#include "silvafit/study/model_library.hpp"

namespace silvafit::cli {

/// A published library, or the one in a file.
/// \throws InputError if it cannot be read; for the folder of a study, with the library's path
study::ModelLibrary library_named(const std::string& name_or_file);

}  // namespace silvafit::cli
