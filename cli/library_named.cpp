// SPDX-License-Identifier: MIT
#include "library_named.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "command.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"

namespace silvafit::cli {

study::ModelLibrary library_named(const std::string& name_or_file) {
  namespace fs = std::filesystem;
  if (kind_of(name_or_file) == PathKind::kFolder) {
    const fs::path inside = fs::path(name_or_file) / "library.json";
    throw InputError(is_there(inside)
                         ? fmt::format("is a folder; its library is {}", inside.string())
                         : "is a folder without a library.json of a study",
                     {.file = name_or_file});
  }
  return study::find_library(name_or_file, data_directory() / "models");
}

}  // namespace silvafit::cli
