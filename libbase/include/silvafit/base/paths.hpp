// SPDX-License-Identifier: MIT
// Types and targets of paths. No function throws std::filesystem_error.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace silvafit {

enum class PathKind { kNothing, kFile, kFolder, kStream };

/// The type of a path after following symbolic links: file, folder, device, pipe or socket.
/// \throws InputError if it cannot be determined: no permission for a parent folder, the name is
/// too
///   long, or links are circular
PathKind kind_of(const std::filesystem::path& path);

/// Whether a path exists.
/// \throws as kind_of()
bool is_there(const std::filesystem::path& path);

/// The absolute path without links and dots; unchanged if it cannot be resolved.
std::filesystem::path followed(const std::filesystem::path& path);

/// The files of a folder with an extension, in alphabetical order.
/// \param ending  with its dot, such as ".json"
/// \throws InputError if the folder cannot be read
std::vector<std::filesystem::path> files_in_folder(const std::filesystem::path& folder,
                                                   std::string_view ending);

}  // namespace silvafit
