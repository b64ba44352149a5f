// SPDX-License-Identifier: MIT
// Tables of lists: of results, each with its values.
#pragma once

#include <functional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// A table with a row for each entry of a list, which must live as long.
template <class Entry>
class ListTable {
 public:
  explicit ListTable(const std::vector<Entry>& entries)
      : entries_(entries), table_(entries.size()) {}

  /// Adds a column of numbers or texts.
  /// \param value  of an entry: a member, or a function
  template <class Value>
  void add(std::string_view name, Value value) {
    using Result = std::remove_cvref_t<std::invoke_result_t<Value&, const Entry&>>;
    std::conditional_t<std::is_arithmetic_v<Result>, std::vector<double>, TextColumn> column;
    column.reserve(entries_.size());
    for (const Entry& entry : entries_) {
      if constexpr (std::is_arithmetic_v<Result>) {
        column.push_back(static_cast<double>(std::invoke(value, entry)));
      } else {
        column.append(std::invoke(value, entry));
      }
    }
    table_.set(name, std::move(column));
  }

  Table table() && { return std::move(table_); }

 private:
  const std::vector<Entry>& entries_;
  Table table_;
};

}  // namespace silvafit::data
