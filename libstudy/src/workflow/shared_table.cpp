// SPDX-License-Identifier: MIT
#include "silvafit/study/shared_table.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string_view>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "workflow/flow.hpp"

namespace silvafit::study {
namespace {

using data::TableText;

/// Rows of a part: the sums of a fit are added part by part.
constexpr std::size_t kRowsOfSharedPart = 4096;
constexpr std::size_t kRowsOfSample = 40000;

/// The labels of a column that were seen so far, unless they are too many for a factor.
class SeenLabels {
 public:
  /// Whether the label is new.
  bool add(std::string_view label) {
    constexpr std::size_t kMost = 200;
    if (labels_.size() >= kMost || labels_.contains(label)) return false;
    labels_.emplace(label);
    return true;
  }

 private:
  std::set<std::string, std::less<>> labels_{};
};

/// Chooses whole groups for the sample.
class Sample {
 public:
  /// \param group  fields of the groups
  Sample(std::vector<std::size_t> group, std::size_t rows)
      : group_(std::move(group)), every_(std::max<std::size_t>(1, rows / kRowsOfSample)) {}

  void add(const std::shared_ptr<const TableText>& part) {
    if (!text_.head) {
      text_.name = part->name;
      text_.separator = part->separator;
      text_.head = part->head;
      texts_.resize(part->head->header.size());
    }
    data::CsvReader reader{data::TableSource(part)};
    std::vector<std::string_view> fields;
    while (reader.next(fields)) {
      std::string label;
      for (const std::size_t field : group_) label.append(data::trimmed(fields[field])) += '\x1f';
      if (lines_.empty() || label != label_) begin(std::move(label));
      is_chosen_ = has_new_label(fields) || is_chosen_;
      data::append_record(fields, text_.separator, records_);
      lines_.push_back(reader.line());
    }
    finish_group();
  }

  std::shared_ptr<const TableText> text() { return std::make_shared<TableText>(std::move(text_)); }

 private:
  void begin(std::string label) {
    finish_group();
    label_ = std::move(label);
    is_chosen_ = groups_++ % every_ == 0;
  }

  void finish_group() {
    if (is_chosen_) {
      text_.text += records_;
      text_.lines.insert(text_.lines.end(), lines_.begin(), lines_.end());
    }
    records_.clear();
    lines_.clear();
  }

  bool has_new_label(const std::vector<std::string_view>& fields) {
    bool any = false;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const bool is_text = std::ranges::find(group_, i) == group_.end() &&
                           text_.head->kinds[i] == data::ColumnKind::kText;
      if (is_text && texts_[i].add(data::trimmed(fields[i]))) any = true;
    }
    return any;
  }

  std::vector<std::size_t> group_;
  std::size_t every_;
  std::size_t groups_ = 0;
  std::string label_{};
  bool is_chosen_ = false;
  std::string records_{};             ///< of the group at work
  std::vector<std::size_t> lines_{};  ///< of these
  std::vector<SeenLabels> texts_{};
  TableText text_{};
};

/// The rows for which a condition holds, of which there may be none.
data::Table chosen_rows(data::Table table, const std::string& condition) {
  if (condition.empty()) return table;
  return table.select(data::rows_that_satisfy(condition, table));
}

/// Part of each row of a table, which has the records of a text but for some.
std::vector<std::size_t> parts_of_rows(const data::Table& table,
                                       const std::vector<std::size_t>& lines,
                                       const std::vector<std::size_t>& parts) {
  std::vector<std::size_t> result;
  result.reserve(table.rows());
  std::size_t record = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    while (lines[record] != table.line(row)) ++record;
    result.push_back(parts[record]);
  }
  return result;
}

}  // namespace

SharedTable read_shared_table(const data::TableSource& source,
                              const ReadingSettings& settings,
                              const ModelColumns& columns,
                              const std::string& group,
                              const std::string& where,
                              const NoteCallback& note) {
  std::vector<std::size_t> fields;
  TableFlow file(
      source,
      settings,
      {.is_in_parts = true, .rows = kRowsOfSharedPart, .threads = 1},
      [&](const std::vector<std::string>& header) {
        fields = stand::fields_of(
            group, header, stand::parse_column_mappings(settings.columns), data::file_of(source));
        if (fields.empty()) {
          throw InputError(data::no_such_column(group, header), {.file = data::file_of(source)});
        }
        return group;
      },
      note);
  const Ranks& ranks = Ranks::of_process();
  Sample sample(fields, file.rows());
  TableText own;
  std::vector<std::size_t> parts;
  std::size_t begin = 0;
  for (std::size_t number = 0; const auto rows = file.next(); ++number) {
    const auto& part = std::get<std::shared_ptr<const TableText>>(*rows);
    sample.add(part);
    if (begin * ranks.size() / std::max<std::size_t>(1, file.rows()) == ranks.rank()) {
      if (!own.head) own = {.name = part->name, .separator = part->separator, .head = part->head};
      own.text += part->text;
      own.lines.insert(own.lines.end(), part->lines.begin(), part->lines.end());
      parts.resize(own.lines.size(), number);
    }
    begin += part->lines.size();
  }

  ReadingState state;
  ModelColumns wanted = columns;
  wanted.state = &state;
  ObservedTable of_sample = read_model_table(sample.text(), settings, wanted, note);
  SharedTable result{.data = {.sample = of_sample.observations()},
                     .recognized = std::move(of_sample.recognized)};
  if (result.data.sample.rows() == 0) {
    throw InputError("there are no rows below the header", {.file = data::file_of(source)});
  }
  if (!where.empty()) result.data.sample = data::rows_where(where, result.data.sample);
  if (!own.head) return result;
  const std::vector<std::size_t> lines = own.lines;
  result.data.own =
      chosen_rows(read_model_table(std::make_shared<TableText>(std::move(own)), settings, wanted)
                      .observations(),
                  where);
  result.data.parts = parts_of_rows(*result.data.own, lines, parts);
  return result;
}

}  // namespace silvafit::study
