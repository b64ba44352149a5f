// SPDX-License-Identifier: MIT
// The labels of groups in fits, and their numbers.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/fit/random_effects.hpp"

namespace silvafit::fit {

using LabelNumbers = std::unordered_map<std::string, Eigen::Index>;

/// The index of each label in a list of distinct ones.
inline LabelNumbers numbered(const std::vector<std::string>& labels) {
  LabelNumbers numbers;
  for (std::size_t k = 0; k < labels.size(); ++k) {
    numbers.emplace(labels[k], static_cast<Eigen::Index>(k));
  }
  return numbers;
}

/// The labels of coarser groups in nested labels.
inline std::vector<std::string> outer_parts(const std::vector<std::string>& labels) {
  std::vector<std::string> parts;
  parts.reserve(labels.size());
  for (const std::string& label : labels) parts.push_back(outer_part(label));
  return parts;
}

/// The label of a row's group; for nested groups by nested_label(). Empty if it is missing.
class GroupLabels {
 public:
  /// \throws UsageError if a column of groups is missing
  GroupLabels(const ModelSpecification& specification, const data::Table& table)
      : inner_(table.labels(specification.random.back().group)) {
    if (specification.random.size() > 1) outer_ = table.labels(specification.random.front().group);
  }

  std::string outer(std::size_t row) const {
    return !outer_ || outer_->is_missing(row) ? std::string() : std::string((*outer_)[row]);
  }
  std::string inner(std::size_t row) const {
    if (inner_.is_missing(row) || (outer_ && outer_->is_missing(row))) return {};
    return outer_ ? nested_label((*outer_)[row], inner_[row]) : std::string(inner_[row]);
  }

 private:
  data::TextColumn inner_;
  std::optional<data::TextColumn> outer_;
};

}  // namespace silvafit::fit
