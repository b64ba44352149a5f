// SPDX-License-Identifier: MIT
// Files that are part of the program.
#pragma once

#include <filesystem>
#include <map>
#include <string_view>

namespace silvafit {

/// Files by their names, which read_file(), files_in_folder(), kind_of() and is_there() find before
/// those on the disk. A program adds its files before it starts threads.
std::map<std::filesystem::path, std::string_view>& built_in_files();

}  // namespace silvafit
