// SPDX-License-Identifier: MIT
#include "silvafit/stand/prepared_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/text_formula.hpp"
#include "trees/column_sources.hpp"
#include "trees/folded_text.hpp"
#include "trees/known_tables.hpp"
#include "trees/measurement_time.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {
namespace {

using Names = std::vector<std::string>;
using Fields = std::vector<std::string_view>;
using Text = std::shared_ptr<const data::TableText>;

/// The given columns, and the status of a known table.
std::vector<ColumnMapping> sources_of_columns(const InventoryOptions& options,
                                              const Names& header) {
  std::vector<ColumnMapping> sources = options.columns;
  const auto status = known_status_column(header);
  if (status && mapping_to("status", sources) == nullptr) sources.push_back({"status", *status});
  return sources;
}

/// A text of records without rows.
data::TableText empty_copy(const data::TableText& text) {
  return {.name = text.name, .separator = text.separator, .head = text.head};
}

void add_record(const Fields& fields, std::size_t line, data::TableText& text) {
  data::append_record(fields, text.separator, text.text);
  text.lines.push_back(line);
}

/// Whether a text stands for a missing value of a standard column, or of another one.
bool is_missing_text(std::string_view text,
                     const std::string& name,
                     const data::CsvReader& reader) {
  if (reader.is_missing(text) || data::is_missing_number(text)) return true;
  double value = 0.0;
  if (!is_measure(name) || !reader.parse_number(text, value)) return false;
  return is_missing_number_of(name, value) || (value == 0.0 && is_zero_missing(name));
}

/// 2 before 10.
struct ShorterFirst {
  bool operator()(const std::string& left, const std::string& right) const {
    return std::pair(left.size(), left) < std::pair(right.size(), right);
  }
};

/// The columns of one measure at several times.
struct WideColumn {
  std::string name{};       ///< of the new column
  std::string measure{};    ///< the same without a unit
  std::string time_name{};  ///< of the column of the times
  /// Whether a value shows that the tree was visited; the date of a visit holds for all rows.
  bool is_of_tree = true;
  std::map<std::string, std::size_t> field_at{};
};

/// \throws UsageError if the pattern has no {name}, or no column fits
WideColumn wide_column(const ColumnMapping& visit, const data::CsvReader& reader) {
  const Names& header = reader.header();
  const std::size_t open = visit.source.find('{');
  const std::size_t close = visit.source.find('}', std::min(open, visit.source.size()));
  if (close == std::string::npos || close < open + 2) {
    throw UsageError(
        fmt::format("'{}' is not a pattern of columns such as DBH_{{year}}", visit.source),
        {.column = "`visits`"});
  }
  const std::string before = visit.source.substr(0, open);
  const std::string after = visit.source.substr(close + 1);
  WideColumn wide{.name = visit.name,
                  .measure = visit.name,
                  .time_name = visit.source.substr(open + 1, close - open - 1)};
  std::set<std::string> units;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const std::string& name = header[i];
    const bool fits = name.size() > before.size() + after.size() && name.starts_with(before) &&
                      name.ends_with(after);
    if (!fits) continue;
    std::string time = name.substr(before.size(), name.size() - before.size() - after.size());
    if (std::isdigit(static_cast<unsigned char>(time.front())) == 0) continue;
    wide.field_at.emplace(std::move(time), i);
    const auto unit = unit_of_field(i, header, reader.layout().units);
    units.insert(unit ? std::string(unit->name) : "");
  }
  if (wide.field_at.empty()) {
    throw InputError(
        fmt::format("no column fits the pattern {} with a number at {{{}}}; available: "
                    "{}",
                    visit.source,
                    wide.time_name,
                    data::list_of(header)),
        {.file = reader.file()});
  }
  if (units.size() > 1) {
    throw UsageError(fmt::format("the columns {} have several units", visit.source),
                     {.file = reader.file(), .column = "`visits`"});
  }
  // A unit of the columns stays a part of the name, by which it is converted.
  if (!units.begin()->empty()) wide.name += " (" + *units.begin() + ")";
  return wide;
}

/// Makes a row for each time of a row with columns for several times.
class Visits {
 public:
  Visits(const std::vector<ColumnMapping>& visits, const data::CsvReader& reader);

  Names header() const;
  void add(const Fields& fields, const data::CsvReader& reader, data::TableText& text) const;
  bool has_years() const {
    return std::ranges::all_of(times_, [](const auto& time) { return years_of(time).has_value(); });
  }
  std::string note() const;
  /// The patterns of columns with the same times in their names that are not read, with the
  /// standard names that they mean, or NAME.
  std::vector<ColumnMapping> unread() const;

 private:
  const Names& old_;
  std::vector<WideColumn> wide_{};
  std::vector<std::size_t> kept_{};  ///< fields
  std::set<std::string, ShorterFirst> times_{};
};

Visits::Visits(const std::vector<ColumnMapping>& visits, const data::CsvReader& reader)
    : old_(reader.header()) {
  std::set<std::size_t> used;
  for (const ColumnMapping& visit : visits) {
    wide_.push_back(wide_column(visit, reader));
    if (wide_.back().time_name != wide_.front().time_name) {
      throw UsageError(fmt::format("{{{}}} and {{{}}} are two names of one time",
                                   wide_.front().time_name,
                                   wide_.back().time_name),
                       {.column = "`visits`"});
    }
    for (const auto& [time, field] : wide_.back().field_at) {
      times_.insert(time);
      used.insert(field);
    }
  }
  for (std::size_t i = 0; i < old_.size(); ++i) {
    if (!used.contains(i)) kept_.push_back(i);
  }
  // Columns that are not ours may be dates, too, unless there are no others.
  const auto is_standard = [](const WideColumn& wide) {
    return tree_column(wide.measure) != nullptr;
  };
  const bool has_standard = std::ranges::any_of(wide_, is_standard);
  for (WideColumn& wide : wide_) wide.is_of_tree = !has_standard || is_standard(wide);
  const Names made = header();
  for (const std::string& name : made) {
    if (std::ranges::count(made, name) == 1 || name.empty()) continue;
    throw UsageError(fmt::format("the table has a column {} beside those of the visits", name),
                     {.file = reader.file(), .column = "`visits`"});
  }
}

Names Visits::header() const {
  Names names;
  for (const std::size_t field : kept_) names.push_back(old_[field]);
  names.push_back(wide_.front().time_name);
  for (const WideColumn& wide : wide_) names.push_back(wide.name);
  return names;
}

/// A time without any value is no visit.
void Visits::add(const Fields& fields, const data::CsvReader& reader, data::TableText& text) const {
  Fields row;
  for (const std::string& time : times_) {
    row.clear();
    for (const std::size_t field : kept_) row.push_back(fields[field]);
    row.emplace_back(time);
    bool is_visited = false;
    for (const WideColumn& wide : wide_) {
      const auto field = wide.field_at.find(time);
      row.push_back(field == wide.field_at.end() ? std::string_view() : fields[field->second]);
      is_visited =
          is_visited || (wide.is_of_tree && !is_missing_text(row.back(), wide.measure, reader));
    }
    if (is_visited) add_record(row, reader.line(), text);
  }
}

std::string Visits::note() const {
  return fmt::format("rows of {} are made of the columns of {}: {}",
                     counted(times_.size(), "time", "times"),
                     wide_.front().time_name,
                     fmt::join(times_, ", "));
}

/// The pattern of a column whose name has a time in it, not as a part of a longer number; empty if
/// it has none.
std::string pattern_with(const std::string& column,
                         const std::string& time,
                         const std::string& time_name) {
  const std::size_t at = column.find(time);
  if (at == std::string::npos) return {};
  const auto is_digit = [&column](std::size_t i) {
    return i < column.size() && std::isdigit(static_cast<unsigned char>(column[i])) != 0;
  };
  if ((at > 0 && is_digit(at - 1)) || is_digit(at + time.size())) return {};
  return column.substr(0, at) + "{" + time_name + "}" + column.substr(at + time.size());
}

std::vector<ColumnMapping> Visits::unread() const {
  std::map<std::string, std::size_t> columns_of;
  for (const std::size_t field : kept_) {
    for (const std::string& time : times_) {
      const std::string pattern = pattern_with(old_[field], time, wide_.front().time_name);
      if (!pattern.empty()) ++columns_of[pattern];
    }
  }
  std::vector<ColumnMapping> unread;
  for (const auto& [pattern, columns] : columns_of) {
    const std::size_t open = pattern.find('{');
    const std::string name = pattern.substr(0, open) + pattern.substr(pattern.find('}', open) + 1);
    const auto meant = meant_name(name);
    if (has_word("date datum fecha", folded_letters(name))) {
      unread.push_back({"date", pattern});
      continue;
    }
    // One column with a number may be anything.
    const bool is_standard = meant && meant->fit != NameFit::kConverted;
    if (is_standard) unread.push_back({std::string(meant->name), pattern});
    if (!is_standard && columns > 1) unread.push_back({"NAME", pattern});
  }
  return unread;
}

/// The note on columns of visits that are not read.
/// \throws UsageError if the status is one of them and growth would take all trees as living
std::string describe_unread(const Visits& visits,
                            const InventoryOptions& options,
                            const std::string& file) {
  const std::vector<ColumnMapping> unread = visits.unread();
  if (unread.empty()) return {};
  std::string patterns;
  std::string setting;
  for (const ColumnMapping& visit : options.visits) {
    setting += fmt::format("{}{}={}", setting.empty() ? "" : ",", visit.name, visit.source);
  }
  for (const ColumnMapping& visit : unread) {
    patterns += (patterns.empty() ? "" : ", ") + visit.source;
    setting += fmt::format(",{}={}", visit.name, visit.source);
  }
  // The number of a visit is no year, beside which the date is the time.
  if (!visits.has_years() && mapping_to("date", unread) != nullptr) {
    for (std::string* const patterns_of : {&patterns, &setting}) {
      for (std::size_t at = patterns_of->find("{year}"); at != std::string::npos;
           at = patterns_of->find("{year}")) {
        patterns_of->replace(at, 6, "{visit}");
      }
    }
  }
  const std::string text = fmt::format(
      "the columns {} have the times of the visits in their names, too, but are not "
      "read; read them with `visits={}`",
      patterns,
      setting);
  const bool has_status = mapping_to("status", unread) != nullptr &&
                          mapping_to("status", options.visits) == nullptr &&
                          mapping_to("status", options.columns) == nullptr;
  if (!has_status || !options.keeps_measurements) return text;
  throw UsageError(text + "; without the status, dead trees would count as survivors",
                   {.file = file, .column = "`visits`"});
}

/// Prepares one table; an object, because its steps share the text.
class Preparation {
 public:
  Preparation(const data::TableSource& source, const InventoryOptions& wanted, bool is_part)
      : wanted_(wanted), is_part_(is_part), reader_(source, wanted.missing) {}

  PreparedTable run();

 private:
  void take_rows();
  void add_texts();
  void choose_rows();
  std::string plots_lost(const Text& chosen) const;
  data::Table columns_of_condition() const;
  data::Table table_of(const Names& columns, Names text_columns) const;
  void add_column(const std::string& name,
                  const std::string& source,
                  bool as_text,
                  data::Table& table) const;
  const Names& header() const { return text_->head->header; }

  const InventoryOptions& wanted_;
  bool is_part_;
  data::CsvReader reader_;
  Text text_{};
  std::size_t made_ = 0;  ///< columns of texts
  Names notes_{};
};

/// The table as text with a head, of a row for each visit if these are in columns.
void Preparation::take_rows() {
  const std::vector<std::size_t> filled = filled_fields(wanted_, reader_.header(), reader_.file());
  for (const std::size_t field : filled) reader_.fill_down(field);
  std::optional<Visits> visits;
  if (!wanted_.visits.empty()) visits.emplace(wanted_.visits, reader_);
  auto text = std::make_shared<data::TableText>();
  text->name = reader_.file();
  text->separator = reader_.has_decimal_commas() ? ';' : ',';
  Fields fields;
  while (reader_.next(fields)) {
    visits ? visits->add(fields, reader_, *text) : add_record(fields, reader_.line(), *text);
  }
  auto head = std::make_shared<data::TableHead>();
  head->header = visits ? visits->header() : reader_.header();
  head->layout = reader_.layout();
  for (std::size_t i = 0; i < head->header.size() && !visits; ++i) {
    head->kinds.push_back(reader_.is_text(i)      ? data::ColumnKind::kText
                          : reader_.is_numbers(i) ? data::ColumnKind::kNumbers
                                                  : data::ColumnKind::kUnknown);
  }
  if (visits) {
    head->layout.units.clear();
    notes_.push_back(visits->note());
    std::string unread = describe_unread(*visits, wanted_, reader_.file());
    if (!unread.empty()) notes_.push_back(std::move(unread));
  }
  text->head = std::move(head);
  text_ = std::move(text);
}

data::Table Preparation::table_of(const Names& columns, Names text_columns) const {
  return data::read_csv_table(
      text_,
      {.columns = columns, .text_columns = std::move(text_columns), .missing = wanted_.missing});
}

void Preparation::add_texts() {
  for (const ColumnMapping& mapping : sources_of_columns(wanted_, header())) {
    const auto formula = data::TextFormula::parse(mapping.source, header(), text_->name);
    if (!formula) continue;
    std::set<std::string> units;
    for (const std::string& column : formula->columns()) {
      const auto unit =
          unit_of_field(*field_named(column, header()), header(), text_->head->layout.units);
      units.insert(unit ? std::string(unit->name) : "");
    }
    if (is_measure(mapping.name) && units.size() > 1) {
      throw UsageError(fmt::format("the columns of {} have several units", mapping.source),
                       {.file = text_->name, .column = "`columns`"});
    }
    const data::CsvReader reader(text_, wanted_.missing);
    const data::TextColumn values = formula->values(
        table_of(formula->all_columns(), formula->columns()),
        [&](std::string_view text) { return is_missing_text(text, mapping.name, reader); });
    auto head = std::make_shared<data::TableHead>(*text_->head);
    head->header.push_back(mapping.source);
    if (!head->kinds.empty()) head->kinds.push_back(data::ColumnKind::kUnknown);
    if (!head->layout.units.empty()) head->layout.units.push_back(*units.begin());
    data::TableText added = empty_copy(*text_);
    added.head = std::move(head);
    data::CsvReader rows(text_);
    Fields fields;
    for (std::size_t i = 0; rows.next(fields); ++i) {
      fields.push_back(values[i]);
      add_record(fields, rows.line(), added);
    }
    text_ = std::make_shared<const data::TableText>(std::move(added));
    ++made_;
  }
}

/// Adds a column that a condition names.
void Preparation::add_column(const std::string& name,
                             const std::string& source,
                             bool as_text,
                             data::Table& table) const {
  const Names parts = is_label(name) ? joined_columns(source, header()) : Names();
  if (!parts.empty()) return table.set(name, joined_labels(table_of(parts, parts), parts));
  const auto reference = data::column_reference(name, source, header(), text_->name);
  const Names columns = reference.columns();
  const data::Table read = table_of(columns, as_text && !reference.expression ? columns : Names());
  if (!is_measure(name) && !reference.expression) {
    return data::copy_column(name, read, reference.text, table);
  }
  std::vector<data::TextCell> ignored;
  table.set(name,
            is_measure(name) ? measured_values(name, reference, read)
                             : data::numbers_of(read, reference, ignored));
}

/// The columns of a condition. Ours are as mapped, or under a usual name; others those of the file.
data::Table Preparation::columns_of_condition() const {
  data::refuse_column_pi(wanted_.where, header());
  data::Table table(text_->lines.size());
  for (const std::string& variable : data::Expression::parse(wanted_.where).variables()) {
    const std::string name = data::column_of(variable);
    if (table.has(name)) continue;
    const auto source =
        source_of(name, header(), text_->head->layout.units, wanted_.columns, text_->name);
    if (!source) {
      throw InputError(fmt::format("unknown column '{}' in the condition {} (put text in double "
                                   "quotes); available: {}",
                                   name,
                                   wanted_.where,
                                   data::list_of(header())),
                       {.file = text_->name, .column = "`where`"});
    }
    add_column(name, source->source, name != variable, table);
  }
  return table;
}

/// Rows that no comparison holds for, because a value is missing.
std::size_t rows_without_value(const data::Table& table, const std::vector<std::size_t>& chosen) {
  std::vector<char> lacks(table.rows(), 0);
  for (const std::string& name : table.names()) {
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const bool is_missing = table.is_numeric(name) ? std::isnan(table.numbers(name)[row])
                                                     : table.text(name).is_missing(row);
      if (is_missing) lacks[row] = 1;
    }
  }
  for (const std::size_t row : chosen) lacks[row] = 0;
  return static_cast<std::size_t>(std::ranges::count(lacks, 1));
}

/// A condition on trees may take all trees of a plot, which then is in no mean per hectare.
/// The field of the time of measurement, if the table has one.
std::optional<std::size_t> time_field(const InventoryOptions& options,
                                      const Names& header,
                                      const std::string& file) {
  for (const char* name : {"year", "date"}) {
    const auto fields = fields_of(name, header, options.columns, file);
    if (!fields.empty()) return fields.front();
  }
  const auto usual = usual_time_column(header);
  return usual ? field_named(*usual, header) : std::nullopt;
}

/// The calendar year of a time, as a text; a time of which it is not known as it is.
std::string calendar_year(std::string_view time) {
  const auto years = years_of(time);
  return years ? fmt::format("{}", std::floor(*years)) : std::string(time);
}

std::string Preparation::plots_lost(const Text& chosen) const {
  const auto fields = fields_of("plot", header(), wanted_.columns, text_->name);
  if (is_part_ || fields.empty()) return {};
  std::optional<std::size_t> time;
  if (wanted_.keeps_measurements) time = time_field(wanted_, header(), text_->name);
  const auto plots_in = [&](const Text& text) {
    std::set<std::string> plots;
    data::CsvReader rows(text);
    Fields row;
    while (rows.next(row)) {
      std::string label;
      for (const std::size_t field : fields) label.append(row[field]).append("+");
      if (time) label += calendar_year(row[*time]);
      plots.insert(std::move(label));
    }
    return plots.size();
  };
  const std::size_t all = plots_in(text_);
  const std::size_t lost = all - plots_in(chosen);
  if (lost == 0) return {};
  return fmt::format(
      "; {} of {} {} no such row and are {} only if a table of `plots` lists them{}",
      lost,
      all,
      time ? "visits of plots have" : "plots have",
      time ? "known, with the trees that died or were cut before them," : "in the sample",
      wanted_.keeps_measurements ? "" : "; `by` keeps them all");
}

void Preparation::choose_rows() {
  if (wanted_.where.empty()) return;
  data::Table table = columns_of_condition();
  table.set_origin(text_->name,
                   std::vector<std::uint32_t>(text_->lines.begin(), text_->lines.end()));
  const std::vector<std::size_t> satisfying = data::rows_that_satisfy(wanted_.where, table);
  const std::size_t lacking = rows_without_value(table, satisfying);
  if (lacking > 0 && wanted_.keeps_measurements) {
    throw InputError(
        fmt::format("{} no value of a column of the condition {}, and the fate of {} would be lost "
                    "with them; write it so that it keeps rows without a value, too, as in "
                    "`dbh >= 7 || status == \"dead\"`",
                    counted(lacking, "row has", "rows have"),
                    wanted_.where,
                    lacking == 1 ? "its tree" : "their trees"),
        {.file = text_->name, .column = "`where`"});
  }
  auto chosen = std::make_shared<data::TableText>(empty_copy(*text_));
  data::CsvReader rows(text_);
  Fields fields;
  auto next = satisfying.begin();
  for (std::size_t row = 0; rows.next(fields) && next != satisfying.end(); ++row) {
    if (*next != row) continue;
    add_record(fields, rows.line(), *chosen);
    ++next;
  }
  if (chosen->lines.empty() && !is_part_) {
    throw InputError(fmt::format("no row satisfies the condition {}", wanted_.where),
                     {.file = text_->name});
  }
  const std::string rows_used =
      is_part_ ? "rows are chosen"
               : fmt::format("{} of {} rows are used", chosen->lines.size(), text_->lines.size());
  notes_.push_back(rows_used + ", by the condition " + wanted_.where + plots_lost(chosen));
  if (lacking > 0 && !is_part_) {
    notes_.push_back(fmt::format("{} no value of a column of the condition and {} not used",
                                 counted(lacking, "row has", "rows have"),
                                 lacking == 1 ? "is" : "are"));
  }
  const std::string odd = data::describe_compared_texts(wanted_.where, table);
  if (!odd.empty() && !is_part_) notes_.push_back(odd);
  text_ = std::move(chosen);
}

PreparedTable Preparation::run() {
  take_rows();
  add_texts();
  choose_rows();
  return {.table = text_, .made = made_, .note = fmt::format("{}", fmt::join(notes_, "; "))};
}

}  // namespace

bool makes_columns(const InventoryOptions& options,
                   const std::vector<std::string>& header,
                   const std::string& file) {
  const auto is_text = [&](const ColumnMapping& mapping) {
    return data::TextFormula::parse(mapping.source, header, file).has_value();
  };
  return !options.visits.empty() ||
         std::ranges::any_of(sources_of_columns(options, header), is_text);
}

PreparedTable prepared_table(const data::TableSource& source,
                             const InventoryOptions& options,
                             bool is_part) {
  const bool is_plain = options.where.empty() && options.visits.empty();
  if (is_plain) {
    const auto* const path = std::get_if<std::filesystem::path>(&source);
    std::error_code ignored;
    // A pipe cannot be read twice.
    const bool is_pipe = path != nullptr && std::filesystem::exists(*path, ignored) &&
                         !std::filesystem::is_regular_file(*path, ignored);
    if (is_pipe) return Preparation(source, options, is_part).run();
    const data::CsvReader reader(source);
    if (!makes_columns(options, reader.header(), reader.file())) return {.table = source};
  }
  return Preparation(source, options, is_part).run();
}

std::vector<std::size_t> filled_fields(const InventoryOptions& options,
                                       const std::vector<std::string>& header,
                                       const std::string& file) {
  std::vector<std::size_t> fields;
  for (const std::string& name : options.fill_down) {
    const auto own = field_named(name, header);
    const auto found = own ? std::vector{*own} : fields_of(name, header, options.columns, file);
    if (found.empty()) {
      throw UsageError(data::no_such_column(name, header), {.column = "`fill_down`"});
    }
    fields.insert(fields.end(), found.begin(), found.end());
  }
  return fields;
}

}  // namespace silvafit::stand
