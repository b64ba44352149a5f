// SPDX-License-Identifier: MIT
#include "silvafit/data/table_parts.hpp"

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/external_sort.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "table/formula_guards.hpp"

namespace silvafit::data {
namespace {

/// Wide records make smaller parts.
constexpr std::size_t kMostBytes = std::size_t{32} << 20U;

/// The kind of a column, by the rules of read_csv_table.
class KindOfColumn {
 public:
  void add(std::size_t column, std::string_view value, CsvReader& reader) {
    if (is_text_ || reader.is_missing(value)) return;
    double number = 0.0;
    if (reader.read_number(column, value, number)) {
      has_numbers_ = true;
    } else if (is_missing_number(value)) {
      has_codes_ = true;
    } else {
      is_text_ = true;
    }
  }

  ColumnKind kind() const {
    if (is_text_) return ColumnKind::kText;
    if (has_numbers_) return ColumnKind::kNumbers;
    return has_codes_ ? ColumnKind::kText : ColumnKind::kUnknown;
  }

 private:
  bool is_text_ = false;
  bool has_numbers_ = false;
  bool has_codes_ = false;
};

/// Numbers groups in the order of their first rows. Labels are kept as hashes of 64 bits: of ten
/// million groups, two have the same hash with a probability of 3e-6; they then share a part.
class GroupNumbers {
 public:
  std::size_t number_of(const std::vector<std::string_view>& fields,
                        const std::vector<std::size_t>& columns) {
    label_.clear();
    // Labels of blanks are one group for any number of blanks.
    for (const std::size_t column : columns) label_.append(trimmed(fields[column])) += '\0';
    // Most rows are of the group above them.
    if (!numbers_.empty() && label_ == last_label_) return last_;
    Fingerprint hash;
    hash.add(label_);
    last_label_ = label_;
    last_ = numbers_.try_emplace(hash.value(), numbers_.size()).first->second;
    return last_;
  }
  std::size_t size() const { return numbers_.size(); }

 private:
  std::unordered_map<std::uint64_t, std::size_t> numbers_{};
  std::string label_{};
  std::string last_label_{};
  std::size_t last_ = 0;
};

}  // namespace

struct TableParts::State {
  State(const std::filesystem::path& file, const TablePartsOptions& wanted)
      : path(file), options(wanted) {
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored) &&
        !std::filesystem::is_regular_file(path, ignored)) {
      throw InputError("a stream cannot be read twice, so give a file", {.file = path.string()});
    }
    survey();
    reader.emplace(open());
    if (is_sorted) sort();
  }
  State(CsvReader opened, const TablePartsOptions& wanted)
      : path(opened.file()), options(wanted), reader(std::move(opened)) {
    take_head(*reader);
  }

  CsvReader open() const {
    CsvReader opened(path, options.missing);
    for (const std::size_t field : options.fill_down) opened.fill_down(field);
    return opened;
  }

  void survey();
  void take_head(const CsvReader& whole);
  void sort();
  bool read_row();

  std::filesystem::path path;
  TablePartsOptions options;
  std::shared_ptr<TableHead> head{};
  char separator = ',';
  std::size_t rows = 0;
  bool is_sorted = false;
  GroupNumbers groups{};
  std::optional<CsvReader> reader{};
  std::optional<ExternalSort> sorted{};

  // The row that comes next.
  std::vector<std::string_view> next_fields{};
  std::string record{};
  std::size_t line = 0;
  std::size_t group = 0;
  std::size_t known_groups = 0;  ///< before this row
  std::size_t finished = 0;      ///< groups of earlier parts
  std::string label{};           ///< of the group, for refuse_group
  bool has_row = false;
  bool is_begun = false;
};

void TableParts::State::survey() {
  CsvReader whole = open();
  std::vector<KindOfColumn> kinds(whole.header().size());
  std::vector<std::string_view> fields;
  std::size_t last = 0;
  std::size_t most = 0;
  while (whole.next(fields)) {
    if (options.finds_kinds || whole.has_decimal_commas()) {
      for (std::size_t i = 0; i < fields.size(); ++i) kinds[i].add(i, fields[i], whole);
    }
    if (!options.group.empty() && !options.refuse_group) {
      const std::size_t number = groups.number_of(fields, options.group);
      if (rows > 0 && number != last && number <= most) is_sorted = true;
      last = number;
      most = std::max(most, number);
    }
    ++rows;
  }
  take_head(whole);
  if (!options.finds_kinds) return;
  for (const KindOfColumn& column : kinds) head->kinds.push_back(column.kind());
}

void TableParts::State::take_head(const CsvReader& whole) {
  separator = whole.has_decimal_commas() ? ';' : ',';
  head = std::make_shared<TableHead>();
  head->header = whole.header();
  head->layout = whole.layout();
  head->marks = whole.marks();
}

void TableParts::State::sort() {
  sorted.emplace();
  std::vector<std::string_view> fields;
  std::string bytes;
  while (reader->next(fields)) {
    bytes.clear();
    append_record(fields, separator, bytes);
    sorted->add({groups.number_of(fields, options.group), reader->line()}, bytes);
  }
  reader.reset();
}

bool TableParts::State::read_row() {
  if (sorted) {
    ExternalSort::Key key;
    if (!sorted->next(key, record)) return false;
    group = key.first;
    line = key.second;
    return true;
  }
  if (!reader->next(next_fields)) return false;
  record.clear();
  append_record(next_fields, separator, record);
  line = reader->line();
  if (options.group.empty()) return true;
  known_groups = groups.size();
  group = groups.number_of(next_fields, options.group);
  if (!options.refuse_group) return true;
  label.clear();
  for (const std::size_t column : options.group) {
    label.append(column == options.group.front() ? "" : "-").append(trimmed(next_fields[column]));
  }
  return true;
}

TableParts::TableParts(const std::filesystem::path& path, const TablePartsOptions& options)
    : state_(std::make_unique<State>(path, options)) {}
TableParts::TableParts(CsvReader reader, const TablePartsOptions& options)
    : state_(std::make_unique<State>(std::move(reader), options)) {}
TableParts::~TableParts() = default;
TableParts::TableParts(TableParts&&) noexcept = default;
TableParts& TableParts::operator=(TableParts&&) noexcept = default;

bool TableParts::is_sorted() const { return state_->is_sorted; }

std::size_t TableParts::rows() const { return state_->rows; }

std::shared_ptr<const TableText> TableParts::next() {
  State& state = *state_;
  const bool is_first = !std::exchange(state.is_begun, true);
  if (is_first) state.has_row = state.read_row();
  if (!is_first && !state.has_row) return nullptr;
  auto part = std::make_shared<TableText>();
  part->name = state.path.string();
  part->separator = state.separator;
  part->head = state.head;
  while (state.has_row) {
    const bool comes_again = state.options.refuse_group && state.group < state.finished;
    if (comes_again) state.options.refuse_group(state.line, state.label);
    part->text += state.record;
    part->lines.push_back(state.line);
    const std::size_t group = state.group;
    state.has_row = state.read_row();
    const bool is_full =
        part->lines.size() >= state.options.rows || part->text.size() >= kMostBytes;
    if (is_full && (state.options.group.empty() || state.group != group)) break;
  }
  state.finished = state.known_groups;
  return part;
}

void append_record(const std::vector<std::string_view>& fields,
                   char separator,
                   std::string& record) {
  const bool is_blank =
      std::ranges::all_of(fields, [](std::string_view field) { return trimmed(field).empty(); });
  bool is_first = true;
  for (const std::string_view original : fields) {
    if (!is_first) record += separator;
    // The reader removes apostrophes from before what looks like a formula.
    const std::string field = with_kept_apostrophes(original);
    // A blank record, and one that begins with a #, would be skipped.
    const bool needs_quotes = (is_first && (is_blank || field.starts_with('#'))) ||
                              std::ranges::any_of(field, [separator](char c) {
                                return c == separator || c == '"' || c == '\r' || c == '\n';
                              });
    is_first = false;
    if (!needs_quotes) {
      record += field;
      continue;
    }
    record += '"';
    for (const char c : field) {
      if (c == '"') record += '"';
      record += c;
    }
    record += '"';
  }
  record += '\n';
}

}  // namespace silvafit::data
