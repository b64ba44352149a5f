// SPDX-License-Identifier: MIT
// Model libraries as the command line names them.
#pragma once

#include <string>

#include "silvafit/study/model_library.hpp"

namespace silvafit::cli {

/// A published library, or the one in a file.
/// \throws InputError if it cannot be read; of a study's folder, it names the file that is meant
study::ModelLibrary library_named(const std::string& name_or_file);

}  // namespace silvafit::cli
