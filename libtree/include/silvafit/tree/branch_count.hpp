// SPDX-License-Identifier: MIT
// Number of first-order branches of a tree by age.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "silvafit/data/expression.hpp"

namespace silvafit::tree {

/// Branch numbers by age from the catalogue (models/branch_count/*.json): formulas of `age` [years]
/// for all first-order branches and for the dead ones among them, valid in a range of ages.
class BranchCount {
 public:
  /// \throws InputError if the file cannot be used, or total > dead > 0 does not hold in the whole
  /// range
  static BranchCount load(const std::filesystem::path& file);

  struct Count {
    double total = 0.0;
    double dead = 0.0;

    double live() const { return total - dead; }
  };
  /// None outside the range of ages.
  std::optional<Count> at(double age_years) const;

  const std::string& name() const { return name_; }
  double youngest_years() const { return youngest_years_; }
  double oldest_years() const { return oldest_years_; }

 private:
  BranchCount(data::Expression total, data::Expression dead);

  std::string name_;
  data::Expression total_;
  data::Expression dead_;
  double youngest_years_ = 0.0;
  double oldest_years_ = 0.0;
};

}  // namespace silvafit::tree
