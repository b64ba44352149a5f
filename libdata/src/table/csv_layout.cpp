// SPDX-License-Identifier: MIT
#include "table/csv_layout.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::data {
namespace {

// The header is searched among this many records.
constexpr std::size_t kMostRecords = 64;
// A header is accepted if this many records below it have its number of fields.
constexpr std::size_t kRecordsBelow = 4;

/// A record of the first bytes of a file.
struct Record {
  std::size_t begin = 0;  ///< offset of its first byte
  std::vector<std::string_view> fields{};

  std::size_t filled() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(fields, [](std::string_view field) { return !field.empty(); }));
  }
  bool is_comment() const { return !fields.empty() && fields.front().starts_with('#'); }
};

/// Splits a text into records; text after a quote that does not end is ignored.
class Splitter {
 public:
  Splitter(std::string_view text, char separator) : text_(text), separator_(separator) {}

  std::vector<Record> records(bool is_whole);

 private:
  bool read_field(Record& record);
  bool at_end() const { return position_ == text_.size(); }

  std::string_view text_;
  char separator_;
  std::size_t position_ = 0;
};

/// False if the text ends within quotes.
bool Splitter::read_field(Record& record) {
  std::size_t begin = position_;
  std::size_t end = begin;
  if (!at_end() && text_[begin] == '"') {
    ++begin;
    end = begin;
    while (end < text_.size() && (text_[end] != '"' || text_.substr(end + 1).starts_with('"'))) {
      end += text_[end] == '"' ? 2 : 1;
    }
    if (end >= text_.size()) return false;
    position_ = end + 1;
  }
  while (!at_end() && text_[position_] != separator_ && !is_line_end(text_[position_])) {
    ++position_;
    end = position_;
  }
  record.fields.push_back(trimmed(text_.substr(begin, end - begin)));
  return true;
}

std::vector<Record> Splitter::records(bool is_whole) {
  std::vector<Record> records;
  while (!at_end() && records.size() < kMostRecords) {
    Record record{.begin = position_};
    if (!read_field(record)) return records;
    while (!at_end() && text_[position_] == separator_) {
      ++position_;
      if (!read_field(record)) return records;
    }
    if (at_end() && !is_whole) return records;
    if (!at_end() && text_[position_] == '\r') ++position_;
    if (!at_end() && text_[position_] == '\n') ++position_;
    if (record.fields.size() > 1 || !record.fields[0].empty()) records.push_back(std::move(record));
  }
  return records;
}

bool is_number(std::string_view field, char separator) {
  double ignored = 0.0;
  if (parse_number(field, ignored)) return true;
  return separator != ',' && !with_decimal_point(field).empty();
}

bool has_number(const Record& record, char separator) {
  return std::ranges::any_of(
      record.fields, [separator](std::string_view field) { return is_number(field, separator); });
}

/// Whether the filled fields are two or more different texts that are no numbers.
bool has_names(const Record& record, char separator) {
  std::set<std::string_view> names;
  for (const std::string_view field : record.fields) {
    if (field.empty()) continue;
    if (is_number(field, separator) || !names.insert(field).second) return false;
  }
  return names.size() >= 2;
}

/// What separates the fields, by the header: a comma; or semicolons or tabs where there is no
/// comma, as spreadsheets write them in languages with a decimal comma.
char separator_of(std::string_view text) {
  bool quoted = false;
  char other = ',';
  bool is_blank = true;
  for (const char c : text) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == ',') return ',';
    if (is_line_end(c) && !is_blank) break;
    if (c == ';' || (c == '\t' && other != ';')) other = c;
    if (c != ' ' && c != '\t' && !is_line_end(c)) is_blank = false;
  }
  return other;
}

/// The number of fields of the first records, if they all have as many; else 0.
std::size_t common_fields(const std::vector<Record>& records) {
  const std::size_t last = std::min(records.size(), 1 + kRecordsBelow);
  const auto is_other = [&records](const Record& record) {
    return record.fields.size() != records.front().fields.size();
  };
  if (last < 2 || std::any_of(records.begin(), records.begin() + last, is_other)) return 0;
  return records.front().fields.size();
}

/// The separator by the header, unless another one makes more fields of the first records: names
/// may have commas, as in `dbh, cm;h, m`.
char separator_by_records(std::string_view text, bool is_whole) {
  const char by_header = separator_of(text);
  if (by_header != ',') return by_header;
  const std::vector<Record> records = Splitter(text, ',').records(is_whole);
  const std::size_t fields = records.empty() ? 0 : records.front().fields.size();
  for (const char other : {';', '\t'}) {
    if (common_fields(Splitter(text, other).records(is_whole)) > fields) return other;
  }
  return ',';
}

bool is_above(const Record& record, const Record& header) {
  return record.is_comment() || record.filled() < header.filled();
}

/// Whether each filled field has a name; row names need none.
bool are_named(const Record& values, const Record& header) {
  for (std::size_t i = 1; i < values.fields.size(); ++i) {
    if (!values.fields[i].empty() && header.fields[i].empty()) return false;
  }
  return true;
}

/// Whether the first record can be the header.
bool begins_with_header(const std::vector<Record>& records) {
  if (records.size() < 2) return true;
  const Record& first = records[0];
  if (first.is_comment() || first.fields.size() < 2) return false;
  const bool is_padded_title = first.fields.size() > 2 && first.filled() < 2;
  if (is_padded_title || records[1].fields.size() != first.fields.size()) return false;
  const std::size_t last = std::min(records.size(), 1 + kRecordsBelow);
  return std::all_of(records.begin() + 1,
                     records.begin() + static_cast<std::ptrdiff_t>(last),
                     [&first](const Record& record) {
                       return record.fields.size() != first.fields.size() ||
                              are_named(record, first);
                     });
}

/// Whether a table begins at a record: names, and numbers below them in records of one length.
bool begins_table(const std::vector<Record>& records, std::size_t at, char separator) {
  const Record& header = records[at];
  if (header.fields.size() < 2 || !has_names(header, separator)) return false;
  const std::size_t last = std::min(records.size(), at + 1 + kRecordsBelow);
  bool found_number = false;
  for (std::size_t i = at + 1; i < last; ++i) {
    if (records[i].fields.size() != header.fields.size()) return false;
    if (!are_named(records[i], header)) return false;
    found_number = found_number || has_number(records[i], separator);
  }
  // A comment above the header has names below it, a header with a # has values.
  if (header.is_comment() && at + 1 < last && !has_number(records[at + 1], separator)) return false;
  return found_number;
}

std::optional<std::size_t> find_header(const std::vector<Record>& records, char separator) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (!begins_table(records, i, separator)) continue;
    const auto above = [&](std::size_t k) { return is_above(records[k], records[i]); };
    bool all_above = true;
    for (std::size_t k = 0; k < i; ++k) all_above = all_above && above(k);
    return all_above ? std::optional(i) : std::nullopt;
  }
  return std::nullopt;
}

/// The unit within brackets, or the text.
std::string_view without_brackets(std::string_view text) {
  if (text.size() < 2) return text;
  const bool has_brackets =
      (text.front() == '(' && text.back() == ')') || (text.front() == '[' && text.back() == ']');
  return has_brackets ? trimmed(text.substr(1, text.size() - 2)) : text;
}

bool is_unit_of_length(std::string_view text) {
  static constexpr std::array<std::string_view, 13> kUnits{
      "m", "cm", "mm", "dm", "in", "inch", "inches", "ft", "feet", "meter", "米", "厘米", "毫米"};
  return std::ranges::find(kUnits, text) != kUnits.end();
}

/// Units of other quantities, and what rows of units have for names and numbers.
bool is_other_unit(std::string_view text) {
  static constexpr std::array<std::string_view, 30> kUnits{
      "-",     "--",   "%",    "°",    "deg",    "degree", "gon",   "grad", "ha",  "m2",
      "m²",    "m^2",  "m3",   "m³",   "m^3",    "m2/ha",  "m²/ha", "a",    "yr",  "year",
      "years", "text", "code", "name", "number", "nr",     "nr.",   "no",   "no.", "株"};
  return std::ranges::find(kUnits, text) != kUnits.end();
}

/// The units in the record below the header; none if it has none. Below a unit of length there must
/// be numbers or nothing.
std::vector<std::string> units_in(const std::vector<Record>& records,
                                  std::size_t header,
                                  char separator) {
  if (header + 2 >= records.size()) return {};
  const Record& row = records[header + 1];
  const Record& below = records[header + 2];
  if (row.fields.size() != records[header].fields.size() ||
      below.fields.size() != row.fields.size()) {
    return {};
  }
  std::vector<std::string> units;
  std::size_t known = 0;
  std::size_t unknown = 0;
  bool has_length_of_number = false;
  for (std::size_t i = 0; i < row.fields.size(); ++i) {
    const std::string_view unit = without_brackets(row.fields[i]);
    units.emplace_back(unit);
    if (unit.empty()) continue;
    if (is_number(unit, separator)) return {};
    const bool is_length = is_unit_of_length(unit);
    is_length || is_other_unit(unit) ? ++known : ++unknown;
    if (!is_length) continue;
    const bool is_value = is_number(below.fields[i], separator);
    if (!is_value && !is_missing_number(below.fields[i])) return {};
    has_length_of_number = has_length_of_number || is_value;
  }
  return has_length_of_number && unknown < known ? units : std::vector<std::string>();
}

TableStart start_at(const std::vector<Record>& records,
                    std::size_t header,
                    char separator,
                    std::string_view text) {
  if (records.empty()) return {.separator = separator};
  const std::size_t begin = records[header].begin;
  return {.separator = separator,
          .bytes_above = begin,
          .lines_above = count_line_ends(text.substr(0, begin)),
          .titles = header,
          .units = units_in(records, header, separator)};
}

}  // namespace

std::string describe_layout(const CsvLayout& layout) {
  std::string text;
  if (layout.titles > 0) {
    text = fmt::format("the header is on line {}, below {}",
                       layout.header_line,
                       counted(layout.titles, "title or comment", "titles or comments"));
  }
  const auto add = [&text](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (!layout.units.empty()) add("the row below the header has units");
  if (layout.comments > 0) {
    add(counted(layout.comments, "comment line is", "comment lines are") + " ignored");
  }
  if (!layout.unnamed.empty()) {
    add(fmt::format("{} {} no name and {} not read",
                    fmt::join(layout.unnamed, ", "),
                    layout.unnamed.size() == 1 ? "has" : "have",
                    layout.unnamed.size() == 1 ? "is" : "are"));
  }
  return text;
}

std::size_t count_line_ends(std::string_view text) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_pair = text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n';
    if (is_line_end(text[i]) && !is_pair) ++count;
  }
  return count;
}

TableStart start_of_table(std::string_view text, bool is_whole, std::optional<char> separator) {
  const char by_first_record = separator.value_or(separator_by_records(text, is_whole));
  std::vector<Record> first = Splitter(text, by_first_record).records(is_whole);
  if (begins_with_header(first)) return start_at(first, 0, by_first_record, text);
  const std::string candidates =
      separator ? std::string(1, *separator) : std::string(1, by_first_record) + ",;\t";
  for (const char candidate : candidates) {
    const std::vector<Record> records = Splitter(text, candidate).records(is_whole);
    const std::optional<std::size_t> header = find_header(records, candidate);
    if (header) return start_at(records, *header, candidate, text);
  }
  return start_at(first, 0, by_first_record, text);
}

}  // namespace silvafit::data
