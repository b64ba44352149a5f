// SPDX-License-Identifier: MIT
#include "silvafit/data/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/name_list.hpp"

namespace silvafit::data {

std::size_t TextColumn::slot_of(std::string_view value) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = std::hash<std::string_view>()(value) & mask;
  while (slots_[slot] != kMissingCode && levels_[slots_[slot]] != value) slot = (slot + 1) & mask;
  return slot;
}

void TextColumn::grow_slots() {
  constexpr std::size_t kFewest = 16;
  slots_.assign(std::max(kFewest, 2 * slots_.size()), kMissingCode);
  for (std::size_t code = 0; code < levels_.size(); ++code) {
    slots_[slot_of(levels_[code])] = static_cast<std::uint32_t>(code);
  }
}

void TextColumn::append(std::string_view value) {
  // Files are often sorted by plot: the value is most likely that of the row before.
  if (!codes_.empty() && codes_.back() != kMissingCode && levels_[codes_.back()] == value) {
    codes_.push_back(codes_.back());
    return;
  }
  if (2 * levels_.size() >= slots_.size()) grow_slots();
  std::uint32_t& code = slots_[slot_of(value)];
  if (code == kMissingCode) {
    code = static_cast<std::uint32_t>(levels_.size());
    levels_.emplace_back(value);
  }
  codes_.push_back(code);
}

std::string in_list(std::string_view name) {
  return name.find(',') == std::string_view::npos ? std::string(name) : fmt::format("'{}'", name);
}

std::string list_of(std::span<const std::string> names) {
  constexpr std::size_t kShown = 40;
  std::string list;
  std::size_t count = 0;
  for (const std::string& name : names) {
    // Columns that commands add for themselves.
    if (name.starts_with('\x1f') || count++ >= kShown) continue;
    list += (list.empty() ? "" : ", ") + in_list(name);
  }
  return count <= kShown ? list : fmt::format("{} and {} more", list, count - kShown);
}

std::string no_such_column(std::string_view name, std::span<const std::string> names) {
  return fmt::format("unknown column '{}'; available: {}",
                     name,
                     names.empty() ? "none besides the standard ones" : list_of(names));
}

std::string_view TextColumn::operator[](std::size_t row) const {
  return is_missing(row) ? std::string_view() : std::string_view(levels_[codes_[row]]);
}

std::uint32_t TextColumn::code_of(std::string_view value) const {
  return slots_.empty() ? kMissingCode : slots_[slot_of(value)];
}

bool Table::has(std::string_view name) const { return slots_.contains(std::string(name)); }

const Table::Slot& Table::slot(std::string_view name) const {
  const auto entry = slots_.find(std::string(name));
  if (entry == slots_.end()) {
    throw UsageError(no_such_column(name, names_), {.file = file_});
  }
  return entry->second;
}

bool Table::is_numeric(std::string_view name) const { return slot(name).numeric; }

std::span<const double> Table::numbers(std::string_view name) const {
  const Slot& found = slot(name);
  if (!found.numeric) {
    throw UsageError("this column holds text, but numbers are needed",
                     {.file = file_, .column = std::string(name)});
  }
  return numeric_[found.index];
}

const TextColumn& Table::text(std::string_view name) const {
  const Slot& found = slot(name);
  if (found.numeric) {
    throw UsageError("this column holds numbers, but text is needed",
                     {.file = file_, .column = std::string(name)});
  }
  return text_[found.index];
}

TextColumn Table::labels(std::string_view name) const {
  const Slot& found = slot(name);
  if (!found.numeric) return text_[found.index];
  TextColumn column;
  column.reserve(rows_);
  for (const double value : numeric_[found.index]) {
    if (std::isnan(value)) {
      column.append_missing();
    } else {
      column.append(shortest(value));
    }
  }
  return column;
}

Table::Slot& Table::slot_for(std::string_view name, std::size_t length) {
  if (!has_size_) {
    rows_ = length;
    has_size_ = true;
  }
  if (length != rows_) {
    throw UsageError(fmt::format("the column has {} rows, the table {}", length, rows_),
                     {.file = file_, .column = std::string(name)});
  }
  const auto [entry, is_new] = slots_.try_emplace(std::string(name));
  if (is_new) names_.emplace_back(name);
  return entry->second;
}

void Table::set(std::string_view name, std::vector<double> values) {
  const bool existed = has(name);
  Slot& target = slot_for(name, values.size());
  if (existed && target.numeric) {
    numeric_[target.index] = std::move(values);
    return;
  }
  if (existed) text_[target.index] = TextColumn();
  target = {.numeric = true, .index = numeric_.size()};
  numeric_.push_back(std::move(values));
}

void Table::set(std::string_view name, TextColumn values) {
  const bool existed = has(name);
  Slot& target = slot_for(name, values.size());
  if (existed && !target.numeric) {
    text_[target.index] = std::move(values);
    return;
  }
  if (existed) numeric_[target.index] = {};
  target = {.numeric = false, .index = text_.size()};
  text_.push_back(std::move(values));
}

Table Table::select(std::span<const std::size_t> row_numbers) const {
  Table result(row_numbers.size());
  for (const std::string& name : names_) {
    const Slot& source = slot(name);
    if (source.numeric) {
      std::vector<double> values(row_numbers.size());
      std::ranges::transform(row_numbers, values.begin(), [&](std::size_t row) {
        return numeric_[source.index][row];
      });
      result.set(name, std::move(values));
      continue;
    }
    TextColumn values;
    values.reserve(row_numbers.size());
    for (const std::size_t row : row_numbers) {
      const TextColumn& column = text_[source.index];
      column.is_missing(row) ? values.append_missing() : values.append(column[row]);
    }
    result.set(name, std::move(values));
  }
  std::vector<std::uint32_t> lines;
  if (!lines_.empty()) {
    for (const std::size_t row : row_numbers) lines.push_back(lines_[row]);
  }
  result.set_origin(file_, std::move(lines));
  return result;
}

void Table::set_origin(std::string file, std::vector<std::uint32_t> lines) {
  file_ = std::move(file);
  lines_ = std::move(lines);
}

std::string shortest(double value) {
  char buffer[32];
  // Whole numbers may be labels: 100000, not 1e+05.
  constexpr double kExact = 9007199254740992.0;  // 2^53
  const bool is_whole = std::abs(value) <= kExact && value == std::floor(value);
  char* const last = buffer + sizeof buffer;
  const auto [end, status] = is_whole ? std::to_chars(buffer, last, value, std::chars_format::fixed)
                                      : std::to_chars(buffer, last, value);
  return status == std::errc() ? std::string(buffer, end) : fmt::format("{}", value);
}

}  // namespace silvafit::data
