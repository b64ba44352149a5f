// SPDX-License-Identifier: MIT
// The labels of groups in fits, and their numbers.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/fit/random_effects.hpp"

namespace silvafit::fit {

using LabelNumbers = std::unordered_map<std::string, Index>;

/// The index of each label in a list of distinct ones.
inline LabelNumbers numbered(const std::vector<std::string>& labels) {
  LabelNumbers numbers;
  for (std::size_t k = 0; k < labels.size(); ++k) {
    numbers.emplace(labels[k], static_cast<Index>(k));
  }
  return numbers;
}

/// The labels of a row's groups; nested ones by nested_label(). Empty if they are missing.
class GroupLabels {
 public:
  /// \throws UsageError if a column of groups is missing
  GroupLabels(const ModelSpecification& specification, const data::Table& table) {
    for (const RandomEffects& term : specification.random) {
      std::vector<data::TextColumn>& columns = terms_.emplace_back();
      for (const std::string& column : outer_columns(specification, term)) {
        columns.push_back(table.labels(column));
      }
      columns.push_back(table.labels(term.group));
    }
  }

  /// The columns of each term, the coarsest first.
  const std::vector<std::vector<data::TextColumn>>& columns() const { return terms_; }
  /// Whether a row has no group in some term.
  bool is_missing(std::size_t row) const {
    return std::ranges::any_of(terms_, [row](const auto& columns) {
      return std::ranges::any_of(columns, [row](const auto& of) { return of.is_missing(row); });
    });
  }
  /// The label in a term.
  std::string of(std::size_t term, std::size_t row) const {
    std::vector<std::string_view> labels;
    for (const data::TextColumn& column : terms_[term]) {
      if (column.is_missing(row)) return {};
      labels.push_back(column[row]);
    }
    return nested_label(labels);
  }

 private:
  /// Labels of the second of two nested levels hold within the first, also where that is not
  /// written.
  static std::vector<std::string> outer_columns(const ModelSpecification& specification,
                                                const RandomEffects& term) {
    const RandomEffects& first = specification.random.front();
    if (term.is_crossed || &term == &first) return term.within;
    return {first.group};
  }

  std::vector<std::vector<data::TextColumn>> terms_;  ///< columns of each
};

}  // namespace silvafit::fit
