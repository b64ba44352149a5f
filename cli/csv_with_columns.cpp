// SPDX-License-Identifier: MIT
#include "csv_with_columns.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>
#include <utility>

#include "prediction_digits.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/tree_table.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

/// For each field of a file, whether its decimal comma becomes a decimal point.
std::vector<char> columns_of_numbers(const data::TableSource& source) {
  data::CsvReader reader(source);
  if (!reader.has_decimal_commas()) return {};
  const std::vector<std::string>& header = reader.header();
  const auto is_label = [](const std::string& name) {
    return name == "plot" || name == "tree" || name == "species";
  };
  std::vector<char> is_number(header.size(), 1);
  const auto keep = [&](const std::string& name) {
    const auto found = std::ranges::find(header, name);
    if (found != header.end()) is_number[static_cast<std::size_t>(found - header.begin())] = 0;
  };
  for (const char* name : {"plot", "tree", "species"}) keep(name);
  for (const auto& usual : stand::usual_columns(header, is_label, reader.file()))
    keep(usual.source);
  std::vector<std::string_view> fields;
  while (reader.next(fields)) {
    for (std::size_t i = 0; i < fields.size(); ++i) {
      double ignored = 0.0;
      const bool fits =
          data::is_missing_number(fields[i]) || reader.parse_number(fields[i], ignored);
      if (!fits) is_number[i] = 0;
    }
  }
  return is_number;
}

/// A field of a new column; empty where it is missing.
std::string field_of(const data::Table& table,
                     const std::string& name,
                     std::size_t row,
                     int digits) {
  if (!table.is_numeric(name)) return std::string(table.text(name)[row]);
  const double value = table.numbers(name)[row];
  return std::isnan(value) ? std::string() : with_digits(value, digits);
}

void write_rows(const data::TableSource& in,
                const AddedColumns& columns,
                const study::ReadingSettings& reading,
                std::ostream& stream) {
  const std::vector<char> is_number = columns_of_numbers(in);
  data::CsvReader reader(in);
  const auto& header = reader.header();
  for (const std::size_t field : study::filled_fields(header, reading, reader.file())) {
    reader.fill_down(field);
  }
  const auto replaced = std::ranges::find(header, columns.replaced) - header.begin();
  std::vector<std::string> added = columns.table.names();
  if (replaced < std::ssize(header)) std::erase(added, columns.replaced);
  const char* separator = "";
  const auto write = [&](std::string_view field) {
    stream << separator << data::csv_field(field);
    separator = ",";
  };
  for (const std::string& name : header) write(name);
  for (const std::string& name : added) write(name);
  stream << '\n';
  std::vector<std::string_view> fields;
  for (std::size_t row = 0; reader.next(fields); ++row) {
    separator = "";
    std::string own;
    if (replaced < std::ssize(fields) && columns.is_replaced(row)) {
      own = field_of(columns.table, columns.replaced, row, columns.digits);
      fields[static_cast<std::size_t>(replaced)] = own;
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const bool may_have_comma = !is_number.empty() && is_number[i] != 0;
      const std::string number =
          may_have_comma ? data::with_decimal_point(fields[i]) : std::string();
      write(number.empty() ? fields[i] : std::string_view(number));
    }
    for (const std::string& name : added) {
      write(field_of(columns.table, name, row, columns.digits));
    }
    stream << '\n';
  }
}

}  // namespace

void write_with_columns(const TreeTable& in,
                        const std::string& out,
                        const AddedColumns& columns,
                        const study::ReadingSettings& reading,
                        const CommonOptions& common) {
  if (is_layer_output(out)) {
    std::ostringstream text;
    write_rows(in.table, columns, reading, text);
    write_trees(out, table_of_csv(std::move(text).str(), out, reading), {}, in.coordinates, common);
  } else if (!out.empty()) {
    AtomicFile file(out);
    write_rows(in.table, columns, reading, file.stream());
    file.commit();
  } else if (!common.json) {
    write_rows(in.table, columns, reading, std::cout);
    finish_standard_output();
  }
}

}  // namespace silvafit::cli
