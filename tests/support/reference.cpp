// SPDX-License-Identifier: MIT
#include "reference.hpp"

namespace silvafit::test {

std::filesystem::path source_file(const std::string& name) {
  return std::filesystem::path(SILVAFIT_SOURCE_DIR) / name;
}

std::filesystem::path data_file(const std::string& name) {
  return std::filesystem::path(SILVAFIT_DATA_DIR) / name;
}

std::filesystem::path reference_data(const std::string& name) {
  const std::filesystem::path folder = source_file("tests/reference");
  const std::filesystem::path own = folder / "data" / name;
  return std::filesystem::exists(own) ? own : folder / "data-gpl" / name;
}

}  // namespace silvafit::test
