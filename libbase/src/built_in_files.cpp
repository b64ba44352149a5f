// SPDX-License-Identifier: MIT
#include "silvafit/base/built_in_files.hpp"

namespace silvafit {

std::map<std::filesystem::path, std::string_view>& built_in_files() {
  static std::map<std::filesystem::path, std::string_view> files;
  return files;
}

}  // namespace silvafit
