// SPDX-License-Identifier: MIT
// Maps with an origin of their own that were read as one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"
#include "trees/inventory_reader.hpp"

namespace silvafit::stand {
namespace {

using RowsAtPlace = std::vector<std::size_t>;

/// Whether a column tells apart the rows of more groups than by chance, in which two rows differ
/// with probability 1 - sum p^2 of the shares p of its values: by three standard deviations of a
/// binomial number.
bool tells_apart(const data::TextColumn& column, const std::vector<RowsAtPlace>& groups) {
  std::vector<double> counts(column.levels().size(), 0.0);
  for (std::size_t row = 0; row < column.size(); ++row) {
    if (column.is_missing(row)) return false;
    ++counts[column.code(row)];
  }
  double same = 0.0;
  for (const double count : counts) {
    const double share = count / static_cast<double>(column.size());
    same += share * share;
  }
  const auto told = std::ranges::count_if(groups, [&column](const RowsAtPlace& rows) {
    return column.code(rows[0]) != column.code(rows[1]);
  });
  constexpr double kDeviations = 3.0;
  const auto n = static_cast<double>(groups.size());
  return static_cast<double>(told) >
         n * (1.0 - same) + kDeviations * std::sqrt(n * same * (1.0 - same));
}

}  // namespace

/// Maps with an origin of their own lie on each other if the column of their names is not read: the
/// trees at one position are of different maps.
void InventoryReader::refuse_overlaid_maps() const {
  const Inventory& inventory = result_.inventory;
  const bool may_be_maps = !plan_.labels[kPlot].exists() && !plan_.time_field && is_of_table();
  if (!may_be_maps || !inventory.has_coordinates() || options_.trust_units) return;
  std::map<std::pair<double, double>, RowsAtPlace> places;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    if (std::isnan(inventory.x[row]) || std::isnan(inventory.y[row])) continue;
    places[{inventory.x[row], inventory.y[row]}].push_back(row);
  }
  std::vector<RowsAtPlace> shared;
  for (auto& [place, rows] : places) {
    if (rows.size() > 1) shared.push_back(std::move(rows));
  }
  if (shared.empty()) return;
  data::CsvTableOptions columns{.missing = options_.missing, .fill_down = plan_.filled_down};
  for (const auto& fields : {plan_.unread, plan_.unit_fields}) {
    for (const std::size_t field : fields) columns.columns.push_back(csv_.header()[field]);
  }
  if (columns.columns.empty()) return;
  const data::Table table = data::read_csv_table(prepared_.table, columns).select(kept_rows_);
  const auto map = std::ranges::find_if(table.names(), [&](const std::string& name) {
    return tells_apart(table.labels(name), shared);
  });
  if (map == table.names().end()) return;
  throw InputError(
      fmt::format("{0} several trees, most of which the column {1} tells apart: if it names plots "
                  "with positions of their own, use `columns=plot={1}`; if not, use "
                  "`trust_units=true`",
                  counted(shared.size(), "position has", "positions have"),
                  data::Expression::variable(*map).text()),
      {.file = file_});
}

}  // namespace silvafit::stand
