// SPDX-License-Identifier: MIT
// Where tests find the data that the project ships.
#pragma once

#include <filesystem>
#include <string>

namespace silvafit::test {

/// A file of the checkout.
std::filesystem::path source_file(const std::string& name);

/// A file of the data that is installed with the program, as the build has them.
std::filesystem::path data_file(const std::string& name);

/// A data set of tests/reference: of its folder data, or of data-gpl, whose files are under the
/// GPL.
std::filesystem::path reference_data(const std::string& name);

}  // namespace silvafit::test
