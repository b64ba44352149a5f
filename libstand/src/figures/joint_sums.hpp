// SPDX-License-Identifier: MIT
// Sums for the joint distribution of two indices.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "silvafit/stand/structure_classes.hpp"

namespace silvafit::stand {

/// Sums over an inventory or its parts.
class JointSums {
 public:
  JointSums(std::string first, std::string second)
      : first_(std::move(first)), second_(std::move(second)) {}

  const std::string& first() const { return first_; }
  const std::string& second() const { return second_; }
  /// \param trees  in the order in which their weights are added
  /// \throws UsageError if a name is none of W, M, U and C
  void add(const StructuralUnits& units, std::span<const std::size_t> trees);
  JointDistribution distribution() const;

 private:
  std::string first_;
  std::string second_;
  JointDistribution sums_{};  ///< weights instead of proportions
  double weight_ = 0.0;
};

}  // namespace silvafit::stand
