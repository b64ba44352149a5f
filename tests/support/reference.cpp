// SPDX-License-Identifier: MIT
#include "reference.hpp"

namespace silvafit::test {

std::filesystem::path source_file(const std::string& name) {
  return std::filesystem::path(SILVAFIT_SOURCE_DIR) / name;
}

std::filesystem::path data_file(const std::string& name) {
  return std::filesystem::path(SILVAFIT_DATA_DIR) / name;
}

std::filesystem::path reference_file(const std::string& name) {
  return std::filesystem::path(SILVAFIT_REFERENCE_DIR) / name;
}

}  // namespace silvafit::test
