// SPDX-License-Identifier: MIT
// Tables of text on standard output.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace silvafit::cli {

/// A number with a given number of digits; a dash if it is not finite.
std::string rounded(double value, int digits = 1);

/// A number, with +- its error if that is known.
std::string with_error(double value, double error, int digits = 1);

std::string name_or(const std::string& name, const char* otherwise);

/// Columns as wide as their widest cell; the first left-aligned, others right-aligned.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header) { rows_.push_back(std::move(header)); }

  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  void print() const;

 private:
  std::vector<std::vector<std::string>> rows_{};
};

}  // namespace silvafit::cli
