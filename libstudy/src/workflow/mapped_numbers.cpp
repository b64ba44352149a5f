// SPDX-License-Identifier: MIT
#include "workflow/mapped_numbers.hpp"

#include "silvafit/data/program.hpp"

namespace silvafit::study {

std::vector<double> mapped_numbers(const data::Table& table,
                                   const std::map<std::string, std::string>& columns,
                                   const std::string& name,
                                   std::vector<data::TextCell>& unreadable) {
  const auto mapped = columns.find(name);
  if (mapped == columns.end() && !table.has(name)) {
    return std::vector<double>(table.rows(), data::kMissing);
  }
  const std::string source = mapped == columns.end() ? name : mapped->second;
  const auto reference = data::column_reference(name, source, table.names(), table.file());
  return data::numbers_of(table, reference, unreadable);
}

}  // namespace silvafit::study
