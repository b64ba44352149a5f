// SPDX-License-Identifier: MIT
#include "silvafit/study/rows_with_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/tree_table.hpp"

namespace silvafit::study {
namespace {

/// For each field of a file, whether its decimal comma becomes a decimal point.
std::vector<char> columns_of_numbers(const data::TableSource& source) {
  data::CsvReader reader(source);
  if (!reader.has_decimal_commas()) return {};
  const std::vector<std::string>& header = reader.header();
  const bool is_part = std::ranges::any_of(header, [&](const std::string& name) {
    const auto field = static_cast<std::size_t>(&name - header.data());
    return reader.is_text(field) || reader.is_numbers(field);
  });
  std::vector<char> is_number(header.size(), 1);
  const auto keep = [&](const std::string& name) {
    const auto found = std::ranges::find(header, name);
    if (found != header.end()) is_number[static_cast<std::size_t>(found - header.begin())] = 0;
  };
  for (const char* name : {"plot", "tree", "species"}) keep(name);
  for (const auto& usual : stand::usual_columns(header, stand::is_label, reader.file()))
    keep(usual.source);
  if (is_part) {
    // The column may be numeric in this part although it is text in the file.
    for (std::size_t i = 0; i < header.size(); ++i) {
      if (reader.is_text(i)) is_number[i] = 0;
    }
    return is_number;
  }
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

}  // namespace

void refuse_known_columns(const std::vector<std::string>& names,
                          const std::vector<std::string>& header,
                          const std::string& file) {
  for (const std::string& name : names) {
    if (std::ranges::find(header, name) == header.end()) continue;
    throw InputError("the file already has this column; rename or remove it there",
                     {.file = file, .column = name});
  }
}

std::string with_digits(double value, int digits) {
  constexpr int kAllDigits = 17;  // distinguishes all doubles
  if (digits >= kAllDigits) return data::shortest(value);
  const std::string text = fmt::format("{:.{}e}", value, digits - 1);
  double rounded = value;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return data::shortest(rounded);
}

void write_rows_with_columns(const data::TableSource& in,
                             const AddedColumns& columns,
                             const ReadingSettings& reading,
                             const RecordSink& sink) {
  const auto* const text = std::get_if<std::shared_ptr<const data::TableText>>(&in);
  const bool is_part = text != nullptr && (*text)->head;
  const stand::InventoryOptions options = inventory_options(reading);
  const stand::PreparedTable prepared = stand::prepared_table(in, options, is_part);
  const std::vector<char> is_number = columns_of_numbers(prepared.table);
  data::CsvReader reader(prepared.table);
  std::vector<std::string> header = reader.header();
  header.resize(header.size() - prepared.made);
  for (const std::size_t field : stand::filled_fields(options, header, reader.file())) {
    reader.fill_down(field);
  }
  const auto replaced = std::ranges::find(header, columns.replaced) - header.begin();
  std::vector<std::string> added = columns.table.names();
  if (replaced < std::ssize(header)) std::erase(added, columns.replaced);
  std::string record;
  const auto write = [&](std::string_view field) { record += data::csv_field(field) + ','; };
  const auto end_record = [&](std::size_t line) {
    record.back() = '\n';
    sink(line, record);
    record.clear();
  };
  for (const std::string& name : header) write(name);
  for (const std::string& name : added) write(name);
  end_record(0);
  std::vector<std::string_view> fields;
  for (std::size_t row = 0; reader.next(fields); ++row) {
    fields.resize(header.size());
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
    end_record(reader.line());
  }
}

data::Table rows_with_columns(const data::TableSource& in,
                              const AddedColumns& columns,
                              const ReadingSettings& reading) {
  std::string text;
  write_rows_with_columns(
      in, columns, reading, [&text](std::size_t, std::string_view record) { text += record; });
  return labeled_table(std::move(text), data::CsvReader(in).file());
}

data::Table labeled_table(std::string text, const std::string& file) {
  const auto csv = std::make_shared<const data::TableText>(
      data::TableText{.name = file, .text = std::move(text), .separator = ','});
  std::vector<std::string> texts{"plot", "tree", "species"};
  const data::CsvReader header(csv);
  for (const auto& usual : stand::usual_columns(header.header(), stand::is_label, file)) {
    texts.push_back(usual.source);
  }
  return data::read_csv_table(csv, {.text_columns = std::move(texts)});
}

}  // namespace silvafit::study
