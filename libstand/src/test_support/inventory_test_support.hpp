// SPDX-License-Identifier: MIT
// Inventories from text, for tests.
#pragma once

#include <string>
#include <vector>

#include "scratch_file.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

inline CheckedInventory read_inventory_text(const std::string& text,
                                            const InventoryOptions& options = {}) {
  const silvafit::test::ScratchFile file(text);
  return read_inventory(file.path(), options);
}

/// `line column: reason` of each problem.
inline std::vector<std::string> problems(const CheckedInventory& checked) {
  std::vector<std::string> texts;
  for (const ExcludedRow& row : checked.excluded) {
    texts.push_back(std::to_string(row.line) + " " + row.column + ": " + row.reason);
  }
  return texts;
}

inline std::string describe_excluded(const CheckedInventory& checked, std::size_t most_shown = 5) {
  ExcludedSummary summary(most_shown);
  summary.add(checked);
  return summary.text(checked.inventory.file);
}

inline InventoryOptions with_columns(const std::string& text) {
  return {.columns = parse_column_mappings(text)};
}

inline bool has_note(const CheckedInventory& checked, const std::string& text) {
  for (const std::string& note : checked.notes) {
    if (note.find(text) != std::string::npos) return true;
  }
  return false;
}

}  // namespace silvafit::stand
