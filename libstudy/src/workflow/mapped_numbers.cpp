// SPDX-License-Identifier: MIT
#include "workflow/mapped_numbers.hpp"

#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::study {

std::optional<std::vector<double>> mapped_numbers(const data::Table& table,
                                                  const std::map<std::string, std::string>& columns,
                                                  const std::string& name) {
  const auto mapped = columns.find(name);
  if (mapped == columns.end() && !table.has(name)) {
    return std::vector<double>(table.rows(), data::kMissing);
  }
  const std::string source = mapped == columns.end() ? name : mapped->second;
  std::vector<data::TextCell> unreadable;
  const auto reference = data::column_reference(name, source, table.names(), table.file());
  std::vector<double> values = data::numbers_of(table, reference, unreadable);
  if (!unreadable.empty()) return std::nullopt;
  return values;
}

}  // namespace silvafit::study
