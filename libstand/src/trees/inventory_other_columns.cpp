// SPDX-License-Identifier: MIT
// Reads the columns of an inventory besides its own. Their type is known only from the whole file.
#include <algorithm>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/program.hpp"
#include "trees/inventory_reader.hpp"

namespace silvafit::stand {

/// Columns of the file that other columns are or are computed from.
std::vector<std::string> InventoryReader::sources_of_others() const {
  std::vector<std::string> columns;
  const auto want = [&](const std::string& name) {
    if (std::ranges::find(columns, name) == columns.end()) columns.push_back(name);
  };
  for (const ColumnMapping& other : plan_.others) {
    if (std::ranges::find(csv_.header(), other.source) != csv_.header().end()) {
      want(other.source);
      continue;
    }
    for (const std::string& variable : data::Expression::parse(other.source).variables()) {
      data::TextMatch match;
      want(data::is_text_match(variable, match) ? match.column : variable);
    }
  }
  // An expression without columns still needs the rows.
  if (columns.empty()) columns.push_back(csv_.header().front());
  return columns;
}

/// Of a whole file: in a separate pass.
void InventoryReader::read_other_columns() {
  result_.inventory.other = data::Table(result_.inventory.size());
  if (plan_.others.empty()) return;
  const data::CsvTableOptions options{
      .columns = sources_of_others(), .missing = options_.missing, .fill_down = plan_.filled_down};
  set_other_columns(data::read_csv_table(prepared_.table, options).select(kept_rows_));
}

/// Of a file in parts: fields and types.
void InventoryReader::find_fields_of_others() {
  if (plan_.others.empty()) return;
  head_of_others_ = std::make_shared<data::TableHead>();
  const std::vector<std::string> wanted = sources_of_others();
  for (const std::string& name : wanted) {
    if (std::ranges::find(csv_.header(), name) != csv_.header().end()) continue;
    throw InputError(data::no_such_column(name, csv_.header()), {.file = csv_.file()});
  }
  for (std::size_t field = 0; field < csv_.header().size(); ++field) {
    const std::string& name = csv_.header()[field];
    if (std::ranges::find(wanted, name) == wanted.end()) continue;
    fields_of_others_.push_back(field);
    head_of_others_->header.push_back(name);
    head_of_others_->kinds.push_back(csv_.is_text(field)      ? data::ColumnKind::kText
                                     : csv_.is_numbers(field) ? data::ColumnKind::kNumbers
                                                              : data::ColumnKind::kUnknown);
  }
}

/// Of a batch, whose trees may be fewer than the rows that were kept at first.
void InventoryReader::read_others_of_batch() {
  if (plan_.others.empty()) return;
  result_.inventory.other = data::Table(result_.inventory.size());
  auto text = std::make_shared<data::TableText>();
  text->name = csv_.file();
  text->text = std::exchange(others_, {});
  text->separator = separator_of_others();
  text->head = head_of_others_;
  text->lines = std::exchange(lines_of_others_, {});
  const std::vector<std::size_t> all = std::exchange(rows_of_others_, {});
  std::vector<std::size_t> rows;
  for (const std::size_t kept : kept_rows_) {
    const auto found = std::ranges::lower_bound(all, kept);
    rows.push_back(static_cast<std::size_t>(found - all.begin()));
  }
  const data::CsvTableOptions options{.columns = sources_of_others(), .missing = options_.missing};
  set_other_columns(
      data::read_csv_table(std::shared_ptr<const data::TableText>(std::move(text)), options)
          .select(rows));
}

void InventoryReader::set_other_columns(const data::Table& source) {
  data::Table& table = result_.inventory.other;
  for (const ColumnMapping& other : plan_.others) {
    if (std::ranges::find(csv_.header(), other.source) == csv_.header().end()) {
      table.set(other.name, data::evaluate(data::Expression::parse(other.source), source));
    } else {
      data::copy_column(other.name, source, other.source, table);
    }
  }
}

}  // namespace silvafit::stand
