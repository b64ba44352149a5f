// SPDX-License-Identifier: MIT
// Columns of the tables that analyses of fits return.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <variant>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::study {

inline const data::Table& table_of(const data::TableSource& source) {
  return *std::get<std::shared_ptr<const data::Table>>(source);
}

/// A column with a number of each row.
template <class Rows, class Value>
std::vector<double> numbers(const Rows& rows, Value value) {
  std::vector<double> column;
  for (const auto& row : rows) column.push_back(static_cast<double>(std::invoke(value, row)));
  return column;
}

inline std::vector<double> numbers(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

/// A column with a text of each row.
template <class Rows, class Value>
data::TextColumn texts(const Rows& rows, Value value) {
  data::TextColumn column;
  for (const auto& row : rows) column.append(std::invoke(value, row));
  return column;
}

/// Adds the columns that have a value for each row.
inline void add_if_known(const char* name, const Eigen::VectorXd& values, data::Table& table) {
  if (values.size() == static_cast<Eigen::Index>(table.rows())) table.set(name, numbers(values));
}

}  // namespace silvafit::study
