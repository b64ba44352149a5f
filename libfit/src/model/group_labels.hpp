// SPDX-License-Identifier: MIT
// The labels of groups in fits, and their numbers.
#pragma once

#include <Eigen/Core>
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

/// The labels of the first term's groups in nested labels.
inline std::vector<std::string> outer_parts(const std::vector<std::string>& labels) {
  std::vector<std::string> parts;
  parts.reserve(labels.size());
  for (const std::string& label : labels) parts.push_back(outer_part(label));
  return parts;
}

/// The labels of a row's groups; nested ones by nested_label(). Empty if they are missing.
class GroupLabels {
 public:
  /// \throws UsageError if a column of groups is missing
  GroupLabels(const ModelSpecification& specification, const data::Table& table) {
    for (const RandomEffects& term : specification.random) {
      terms_.push_back(table.labels(term.group));
    }
  }

  /// The label in a term.
  std::string of(std::size_t term, std::size_t row) const {
    for (std::size_t t = 0; t <= term; ++t) {
      if (terms_[t].is_missing(row)) return {};
    }
    return term == 0 ? std::string(terms_[0][row]) : nested_label(terms_[0][row], terms_[1][row]);
  }

 private:
  std::vector<data::TextColumn> terms_;
};

}  // namespace silvafit::fit
