// SPDX-License-Identifier: MIT
// Tables of text on standard output.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::cli {

/// A number with a given number of digits; a dash if it is not finite.
std::string rounded(double value, int digits = 1);

/// A number, with +- its error if that is known.
std::string with_error(double value, double error, int digits = 1);

std::string name_or(const std::string& name, const char* otherwise);

/// How a column of a table is shown.
struct ShownColumn {
  std::string column{};
  std::string title{};
  int digits = 1;
  std::string error{};          ///< column with its standard errors; empty: none
  const char* otherwise = "-";  ///< where a text is missing
};

/// Columns as wide as their widest cell; the first left-aligned, others right-aligned.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header) { rows_.push_back(std::move(header)); }
  explicit TextTable(std::vector<ShownColumn> columns);

  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  /// Adds the shown columns of all rows.
  void add(const data::Table& table);
  void print() const;

 private:
  std::vector<ShownColumn> columns_{};
  std::vector<std::vector<std::string>> rows_{};
};

}  // namespace silvafit::cli
