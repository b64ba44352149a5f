// SPDX-License-Identifier: MIT
#include "tree_table.hpp"

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::cli {

std::map<std::string, std::string> column_map(const std::vector<std::string>& entries) {
  std::map<std::string, std::string> map;
  for (const std::string& entry : entries) {
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size()) {
      throw UsageError("--columns takes name=expression, not " + entry);
    }
    map[entry.substr(0, equals)] = entry.substr(equals + 1);
  }
  return map;
}

data::Table read_tree_table(const std::filesystem::path& file,
                            const std::map<std::string, std::string>& columns) {
  data::CsvTableOptions csv{.text_columns = {"plot", "tree", "species"}};
  for (const char* name : {"plot", "tree", "species"}) {
    const auto mapped = columns.find(name);
    if (mapped != columns.end()) csv.text_columns.push_back(mapped->second);
  }
  return data::read_csv_table(file, csv);
}

}  // namespace silvafit::cli
