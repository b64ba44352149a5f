// SPDX-License-Identifier: MIT
#include "report/table_json.hpp"

#include <utility>

#include "silvafit/base/json_values.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

const char* kind_text(ColumnKind kind) {
  switch (kind) {
    case ColumnKind::kText:
      return "text";
    case ColumnKind::kCount:
      return "count";
    case ColumnKind::kEstimate:
      return "estimate";
    case ColumnKind::kCriterion:
      return "criterion";
    case ColumnKind::kShare:
      return "share";
    case ColumnKind::kPercent:
      return "percent";
    case ColumnKind::kP:
      return "p";
  }
  return "text";
}

ordered_json cell_value(const TableCell& cell, ColumnKind kind) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (std::holds_alternative<MarkedNumber>(cell)) return shown_text(cell, kind);
  const auto* value = std::get_if<double>(&cell);
  return value != nullptr ? number_or_null(*value) : ordered_json(nullptr);
}

}  // namespace

ordered_json json_of(const FormattedTable& table) {
  ordered_json columns = ordered_json::array();
  for (const TableColumn& column : table.columns) {
    columns.push_back(
        {{"name", column.name}, {"title", column.title}, {"kind", kind_text(column.kind)}});
  }
  ordered_json rows = ordered_json::array();
  for (const TableRow& row : table.rows) {
    ordered_json cells = ordered_json::array();
    for (std::size_t i = 0; i < row.size(); ++i) {
      cells.push_back(cell_value(row[i], table.columns[i].kind));
    }
    rows.push_back(std::move(cells));
  }
  return {{"name", table.name},
          {"caption", table.caption},
          {"columns", std::move(columns)},
          {"rows", std::move(rows)}};
}

}  // namespace silvafit::study
