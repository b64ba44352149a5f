// SPDX-License-Identifier: MIT
// Tables as CSV files.
#include <charconv>
#include <cmath>
#include <ostream>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::data {
namespace {

/// Where a column's values are found, looked up once a table.
struct ColumnView {
  std::span<const double> numbers{};
  const TextColumn* text = nullptr;
};

std::vector<ColumnView> views_of(const Table& table) {
  std::vector<ColumnView> views;
  for (const std::string& name : table.names()) {
    if (table.is_numeric(name)) {
      views.push_back({.numbers = table.numbers(name)});
    } else {
      views.push_back({.text = &table.text(name)});
    }
  }
  return views;
}

void append_number(std::string& out, double value) {
  if (std::isnan(value)) return;
  char digits[32];
  const auto [end, status] = std::to_chars(digits, digits + sizeof digits, value);
  out.append(digits, end);
}

std::string header_of(const Table& table) {
  std::string header;
  for (const std::string& name : table.names()) {
    if (&name != &table.names().front()) header += ',';
    header += csv_field(name);
  }
  return header + '\n';
}

void append_row(std::string& out, const std::vector<ColumnView>& views, std::size_t row) {
  const std::size_t start = out.size();
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i > 0) out += ',';
    if (views[i].text == nullptr) {
      append_number(out, views[i].numbers[row]);
    } else if (!views[i].text->is_missing(row)) {
      out += csv_field((*views[i].text)[row]);
    }
  }
  // A row of missing values must not look like an empty line, which readers skip.
  if (out.find_first_not_of(',', start) == std::string::npos) out.insert(start, "\"\"");
  out += '\n';
}

}  // namespace

void write_csv_table(const Table& table, std::ostream& stream) {
  std::string out = header_of(table);
  constexpr std::size_t kFlushAt = std::size_t{1} << 18U;
  const std::vector<ColumnView> views = views_of(table);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    append_row(out, views, row);
    if (out.size() < kFlushAt) continue;
    stream.write(out.data(), static_cast<std::streamsize>(out.size()));
    out.clear();
  }
  stream.write(out.data(), static_cast<std::streamsize>(out.size()));
}

void write_csv_table(const Table& table, const std::filesystem::path& path) {
  AtomicFile file(path);
  write_csv_table(table, file.stream());
  file.commit();
}

}  // namespace silvafit::data
