// SPDX-License-Identifier: MIT
// What the names of files and folders stand for. Nothing here throws std::filesystem_error.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace silvafit {

enum class PathKind { kNothing, kFile, kFolder, kStream };

/// What has this name, behind symbolic links: a file, a folder, or a device, pipe or socket.
/// \throws InputError if the system does not tell: a folder above may not be searched, the name is
///   too long, or links lead in a circle
PathKind kind_of(const std::filesystem::path& path);

/// Whether anything has this name.
/// \throws as kind_of()
bool is_there(const std::filesystem::path& path);

/// The path from the root without links and dots, as far as it can be followed; else as it is.
std::filesystem::path followed(const std::filesystem::path& path);

/// The files of a folder whose names have this ending, in alphabetical order.
/// \param ending  with its dot, such as ".json"
/// \throws InputError if the folder cannot be read
std::vector<std::filesystem::path> files_in_folder(const std::filesystem::path& folder,
                                                   std::string_view ending);

}  // namespace silvafit
