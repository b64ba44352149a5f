// SPDX-License-Identifier: MIT
// The fields of an inventory's rows as labels and numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/data/row_contents.hpp"
#include "silvafit/stand/similar_plots.hpp"
#include "trees/inventory_reader.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {

/// Digits with other marks than those of the file are numbers whose rows must not be lost, and they
/// show that numbers with fewer digits may be read wrongly: 1.001 beside 1.001,5.
void InventoryReader::refuse_other_marks(std::string_view text, const std::string& column) const {
  constexpr std::string_view kDigits = "0123456789";
  std::string plain(text);
  for (const std::string_view sign : {"'", " ", "’", "\u00a0", "\u202f"}) {
    for (std::size_t at = plain.find(sign); at != std::string::npos; at = plain.find(sign)) {
      const std::size_t group = at + sign.size();
      const std::size_t end = std::min(plain.find_first_not_of(kDigits, group), plain.size());
      if (end - group != 3) return;
      plain.replace(at, sign.size(), ",");
    }
  }
  const bool is_of_digits = plain.find_first_of(kDigits) == 0 &&
                            plain.find_first_not_of("0123456789.,") == std::string::npos &&
                            plain.find_last_of(kDigits) + 1 == plain.size();
  if (!is_of_digits) return;
  throw InputError(
      fmt::format("'{}' is no number here: write decimals with a {}, and thousands without a "
                  "separator",
                  text,
                  csv_.has_decimal_commas() ? "comma" : "point"),
      {.file = csv_.file(), .line = csv_.line(), .column = column});
}

/// The marks of all columns that were read as numbers, at the end of the file.
void InventoryReader::require_clear_marks() const {
  std::vector<std::size_t> fields;
  for (const Source& source : plan_.measures) {
    if (source.field) fields.push_back(*source.field);
  }
  for (const ExpressionField& source : plan_.expression_fields) {
    if (!source.is_text) fields.push_back(source.field);
  }
  csv_.require_clear_marks(fields);
}

double InventoryReader::number_in(std::size_t position,
                                  std::string_view field,
                                  const std::string& column,
                                  bool is_position,
                                  InventoryRow& row) {
  const std::string_view text = data::trimmed(field);
  double value = 0.0;
  const bool is_number = csv_.read_number(position, text, value) && !std::isnan(value);
  csv_.require_one_mark(position);
  const bool is_code = is_number
                           ? value < 0.0 && is_missing_number_of(is_position ? "x" : "h", value)
                           : data::is_missing_number(text);
  const bool is_further_code = !options_.missing.empty() && csv_.is_missing(text);
  if (is_number && !is_code && !is_further_code) return value;
  if (is_code || is_further_code) {
    if (!is_missing(text)) codes_.add(column, text);
    return data::kMissing;
  }
  refuse_other_marks(text, column);
  // Letters such as x are marks, too.
  const bool is_name = text.size() > 2 && (meant_name(text) || is_summary_label(text));
  if (is_name && text != csv_.header()[position]) {
    row.heading = fmt::format(
        "has '{}' in the column {}, as headings of another table have; put "
        "what begins there into a file of its own",
        text,
        column);
  }
  row.unreadable.push_back(
      {.column = column,
       .value = std::string(text),
       .reason =
           fmt::format("'{}' is not a number; leave missing values empty or write NA, or name "
                       "other codes with `missing`",
                       text)});
  return data::kMissing;
}

/// Declinations and bearings taken backwards add up to half a circle to a direction.
void InventoryReader::require_computed_directions(const data::Table& table) const {
  const std::vector<double> values = data::evaluate(*plan_.azimuth, table);
  for (std::size_t row = 0; row < block_size_; ++row) {
    if (std::isnan(values[row]) || (values[row] >= -180.0 && values[row] <= 540.0)) continue;
    throw InputError(fmt::format("the azimuth {} by '{}' is no direction in degrees",
                                 values[row],
                                 plan_.azimuth->text()),
                     {.file = csv_.file(), .line = block_[row].line, .column = "azimuth"});
  }
}

/// 0 in a measure that cannot be 0 is a missing-value code.
void InventoryReader::find_missing_zeros(Measures& measures) {
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    if (measures[i] != 0.0 || !is_zero_missing(known_measure(i).name)) continue;
    codes_.add(plan_.measures[i].text, "0");
    measures[i] = data::kMissing;
  }
  const bool has_no_crown =
      std::isnan(measures[kCw]) &&
      std::ranges::all_of(kRadii, [&](Measure radius) { return measures[radius] == 0.0; });
  if (!has_no_crown) return;
  for (const Measure radius : kRadii) {
    codes_.add(plan_.measures[radius].text, "0");
    measures[radius] = data::kMissing;
  }
}

/// Rows that may stand for several trees.
void InventoryReader::count_tally(const std::vector<std::string_view>& fields) {
  double trees = 0.0;
  if (plan_.tally_field && data::parse_number(data::trimmed(fields[*plan_.tally_field]), trees)) {
    ++tally_rows_;
    if (trees != 1.0) ++tally_others_;
    if (trees > 1.0 && trees == std::floor(trees)) ++tally_several_;
    if (trees == 0.0) ++tally_none_;
  }
}

/// The columns of expressions, at the row's position in the block.
void InventoryReader::read_expression_fields(const std::vector<std::string_view>& fields,
                                             InventoryRow& row,
                                             std::size_t position) {
  for (std::size_t i = 0; i < plan_.expression_fields.size(); ++i) {
    const ExpressionField& source = plan_.expression_fields[i];
    if (!source.is_text) {
      double& value = expression_numbers_[i][position];
      value = number_in(source.field, fields[source.field], source.name, source.is_position, row);
      require_polar(
          value, source.polar, {.file = csv_.file(), .line = csv_.line(), .column = source.name});
    } else if (is_missing(data::trimmed(fields[source.field]))) {
      expression_texts_[i].append_missing();
    } else {
      expression_texts_[i].append(data::trimmed(fields[source.field]));
    }
  }
}

void InventoryReader::read_row(const std::vector<std::string_view>& fields,
                               InventoryRow& row,
                               std::size_t position) {
  row.line = csv_.line();
  row.content = 0;
  row.heading.clear();
  std::size_t filled = 0;
  std::string_view last;
  for (const std::string_view field : fields) {
    const std::string_view text = data::trimmed(field);
    row.content = data::content_with(row.content, text);
    if (text.empty()) continue;
    ++filled;
    last = text;
  }
  // Two columns are too few to tell a heading from a row without measures.
  double ignored = 0.0;
  const bool is_alone = filled == 1 && fields.size() > 2 && !data::parse_number(last, ignored);
  if (is_alone && !plan_.labels[kPlot].exists()) {
    row.heading = fmt::format(
        "has only the text '{}', as headings of plots have, but there is no "
        "column plot; give each row its plot in a column",
        last);
  }
  row.unreadable.clear();
  for (std::size_t i = 0; i < kLabelCount; ++i) {
    const Source& source = plan_.labels[i];
    if (source.field) row.labels[i] = data::trimmed(fields[*source.field]);
    if (source.joined.empty()) continue;
    std::vector<std::string_view> parts;
    for (const std::size_t field : source.joined) parts.push_back(fields[field]);
    row.labels[i] = joined_label(parts);
  }
  if (plan_.time_field) row.time = data::trimmed(fields[*plan_.time_field]);
  for (std::size_t i = 0; i < plan_.unit_fields.size(); ++i) {
    row.units[i] = data::trimmed(fields[plan_.unit_fields[i]]);
  }
  if (plan_.genus_field) row.genus = data::trimmed(fields[*plan_.genus_field]);
  row.stem.clear();
  for (const std::size_t field : plan_.stem_fields) {
    row.stem += (row.stem.empty() ? "" : "-") + std::string(data::trimmed(fields[field]));
  }
  row.location.clear();
  for (const std::size_t field : plan_.location) {
    row.location += fmt::format("{}{}", row.location.empty() ? "" : "-", fields[field]);
  }
  if (plan_.status_field) row.status = data::trimmed(fields[*plan_.status_field]);
  if (plan_.factor_field) row.factor = data::trimmed(fields[*plan_.factor_field]);
  count_tally(fields);
  row.status_words.clear();
  const bool may_lack_status = options_.keeps_measurements && !plan_.status_field;
  for (std::size_t i = 0; i < plan_.unread.size(); ++i) {
    auto* const word = unread_[i].find(data::trimmed(fields[plan_.unread[i]]));
    if (word != nullptr && (word->second.is_gone || may_lack_status)) {
      row.status_words.emplace_back(i, word);
    }
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const Source& source = plan_.measures[i];
    const bool is_position = known_measure(i).is_position();
    row.measures[i] = data::kMissing;
    if (!source.field) continue;
    const std::size_t field = *source.field;
    row.measures[i] = number_in(field, fields[field], source.text, is_position, row);
  }
  read_expression_fields(fields, row, position);
}

bool InventoryReader::read_block() {
  expression_numbers_.assign(plan_.expression_fields.size(), std::vector<double>(kBlockRows));
  expression_texts_.assign(plan_.expression_fields.size(), {});
  std::vector<std::string_view> fields;
  block_size_ = 0;
  while (block_size_ < kBlockRows && csv_.next(fields)) {
    read_row(fields, block_[block_size_], block_size_);
    ++block_size_;
  }
  evaluate_expressions();
  return block_size_ > 0;
}

void InventoryReader::evaluate_expressions() {
  const auto is_computed = [](const Source& source) { return source.expression.has_value(); };
  if (block_size_ == 0 || std::ranges::none_of(plan_.measures, is_computed)) return;
  data::Table table(block_size_);
  for (std::size_t i = 0; i < plan_.expression_fields.size(); ++i) {
    const ExpressionField& field = plan_.expression_fields[i];
    expression_numbers_[i].resize(block_size_);
    if (field.is_text) {
      table.set(field.name, std::move(expression_texts_[i]));
    } else {
      table.set(field.name, std::move(expression_numbers_[i]));
    }
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    if (!plan_.measures[i].expression) continue;
    const std::vector<double> values = data::evaluate(*plan_.measures[i].expression, table);
    for (std::size_t row = 0; row < block_size_; ++row) block_[row].measures[i] = values[row];
  }
  if (plan_.azimuth) require_computed_directions(table);
}

}  // namespace silvafit::stand
