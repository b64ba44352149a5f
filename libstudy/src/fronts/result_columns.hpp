// SPDX-License-Identifier: MIT
// Columns of the tables that analyses of fits return.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::study {

inline std::vector<double> numbers(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

/// Adds the columns that have a value for each row.
inline void add_if_known(const char* name, const Eigen::VectorXd& values, data::Table& table) {
  if (values.size() == static_cast<Eigen::Index>(table.rows())) table.set(name, numbers(values));
}

}  // namespace silvafit::study
