// SPDX-License-Identifier: MIT
// Where tests find data: what the project ships, and the reference numbers that may lie beside the
// checkout.
#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

namespace silvafit::test {

/// A file of the checkout.
std::filesystem::path source_file(const std::string& name);

/// A file of the data that is installed with the program, as the build has them.
std::filesystem::path data_file(const std::string& name);

/// A file of the reference numbers, which are not part of the project.
std::filesystem::path reference_file(const std::string& name);

}  // namespace silvafit::test

/// Ends the test case with a message where a reference file is missing.
#define SILVAFIT_NEEDS_REFERENCE(name)                                                \
  do {                                                                                \
    if (!std::filesystem::exists(silvafit::test::reference_file(name))) {             \
      WARN("skipped: the reference file " << (name) << " is not beside the project"); \
      return;                                                                         \
    }                                                                                 \
  } while (false)
