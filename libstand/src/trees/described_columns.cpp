// SPDX-License-Identifier: MIT
#include "silvafit/stand/described_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/expression.hpp"
#include "trees/column_sources.hpp"
#include "trees/folded_text.hpp"
#include "trees/measurement_time.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {
namespace {

using Names = std::vector<std::string>;

/// Such as DBH_{year}, if two columns differ in the year in their name only; else empty.
std::string pattern_of_visits(const Names& columns) {
  constexpr std::string_view kDigits = "0123456789";
  std::set<std::string> patterns;
  for (const std::string& column : columns) {
    const std::size_t begin = column.find_first_of(kDigits);
    if (begin == std::string::npos) continue;
    const std::size_t end = std::min(column.find_first_not_of(kDigits, begin), column.size());
    if (!years_of(column.substr(begin, end - begin))) continue;
    std::string pattern = column.substr(0, begin) + "{year}" + column.substr(end);
    if (!patterns.insert(pattern).second) return pattern;
  }
  return {};
}

/// The columns that commands read; further ones make more results.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kNeeds{
    {{"stand", "dbh"},
     {"indices", "x y dbh"},
     {"study", "dbh h"},
     {"impute", "dbh h"},
     {"grow", "dbh"},
     {"view", "x y dbh h hcb cw"}}};

/// The words of a text between signs, digits and capitals: `DBH.2018` has dbh and 2018.
Names words_of(std::string_view text) {
  Names words(1);
  char last = '\0';
  const auto kind = [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isdigit(byte) != 0) return '0';
    return byte >= 0x80 || std::isalpha(byte) != 0 ? 'a' : '.';
  };
  for (const char c : text) {
    if (kind(c) != kind(last) && !words.back().empty()) words.emplace_back();
    if (kind(c) != '.') words.back() += c;
    last = c;
  }
  for (std::string& word : words) word = folded_letters(word);
  std::erase(words, "");
  return words;
}

/// Describes one table; an object, because its steps share the table.
class Describer {
 public:
  Describer(const data::TableSource& source, const InventoryOptions& options)
      : options_(options),
        prepared_(prepared_table(source, options)),
        reader_(prepared_.table, options.missing) {
    result_.file = reader_.file();
  }

  TableDescription run();

 private:
  void find_sources();
  void add_source(const std::string& name, const std::string& source);
  void describe(const std::string& column);
  bool is_empty(std::string_view name) const;
  void add_lacks();
  void note(std::string text) {
    if (!text.empty()) result_.notes.push_back(std::move(text));
  }
  const Names& header() const { return reader_.header(); }

  const InventoryOptions& options_;
  PreparedTable prepared_;
  data::CsvReader reader_;
  data::Table table_{};
  data::MissingCodes codes_{};
  std::vector<ColumnMapping> sources_{};               ///< of standard columns, and of mapped ones
  std::multimap<std::string, std::size_t> readers_{};  ///< sources of a column of the file
  TableDescription result_{};
};

void Describer::add_source(const std::string& name, const std::string& source) {
  sources_.push_back({.name = name, .source = source});
  Names columns = is_label(name) ? joined_columns(source, header()) : Names();
  if (columns.empty()) {
    const auto reference = data::column_reference(name, source, header(), reader_.file());
    columns = reference.columns();
  }
  for (const std::string& column : columns) readers_.emplace(column, sources_.size() - 1);
}

void Describer::find_sources() {
  const auto& units = reader_.layout().units;
  for (const ColumnMapping& mapping : options_.columns) {
    if (is_no_column(mapping, header())) continue;
    add_source(mapping.name, in_our_unit(mapping, header(), units).source);
  }
  for (const TreeColumn& column : tree_columns()) {
    const std::string name(column.name);
    const bool is_found_otherwise = name == "status" || column.makes_position();
    if (is_found_otherwise || mapping_to(name, options_.columns) != nullptr) continue;
    try {
      if (const auto source = source_of(name, header(), units, options_.columns, "")) {
        add_source(name, source->source);
      }
    } catch (const UsageError& error) {
      note(error.message());
    }
  }
  const auto add_other = [this](const std::string& name, const auto& column) {
    if (column && mapping_to(name, options_.columns) == nullptr) add_source(name, *column);
  };
  add_other("status", status_column(header(), options_.columns, {}, {}, reader_.file()));
  add_other("year", usual_time_column(header()));
}

void Describer::describe(const std::string& column) {
  DescribedColumn described{.name = column, .is_numeric = table_.is_numeric(column)};
  const auto [first, last] = readers_.equal_range(column);
  for (auto reader = first; reader != last; ++reader) {
    const ColumnMapping& source = sources_[reader->second];
    described.read_as += (described.read_as.empty() ? "" : ", ") + source.name;
    if (source.source != column) described.source = source.source;
    const TreeColumn* const standard = tree_column(source.name);
    if (standard != nullptr) described.unit = standard->unit;
  }
  std::vector<double> values;
  const TreeColumn* const standard =
      first == last ? nullptr : tree_column(sources_[first->second].name);
  if (standard != nullptr && standard->is_measure()) {
    const auto reference = data::column_reference(
        described.read_as, sources_[first->second].source, table_.names(), reader_.file());
    data::Table read(table_.rows());
    for (const auto& [used, source] : readers_) {
      if (source == first->second) data::copy_column(used, table_, used, read);
    }
    // A source of several columns is described with each of them.
    const auto note_code = [&](const std::string& of, const std::string& code) {
      if (of == column || of == reference.text) codes_.add(column, code);
    };
    values = measured_values(standard->name, reference, std::move(read), note_code);
  } else if (described.is_numeric) {
    values.assign(table_.numbers(column).begin(), table_.numbers(column).end());
  }
  if (described.is_numeric || !values.empty()) {
    std::vector<double> known;
    std::ranges::copy_if(
        values, std::back_inserter(known), [](double value) { return !std::isnan(value); });
    described.is_numeric = true;
    described.missing = values.size() - known.size();
    described.lowest = known.empty() ? data::kMissing : *std::ranges::min_element(known);
    described.highest = known.empty() ? data::kMissing : *std::ranges::max_element(known);
    described.impossible = static_cast<std::size_t>(std::ranges::count_if(
        known, [&](double value) { return standard != nullptr && !standard->is_possible(value); }));
  } else {
    constexpr std::size_t kExamples = 3;
    const data::TextColumn& texts = table_.text(column);
    for (std::size_t row = 0; row < texts.size(); ++row) {
      if (texts.is_missing(row)) ++described.missing;
    }
    described.different = texts.levels().size();
    const auto shown = std::min(kExamples, texts.levels().size());
    described.examples.assign(texts.levels().begin(),
                              texts.levels().begin() + static_cast<std::ptrdiff_t>(shown));
  }
  result_.columns.push_back(std::move(described));
}

/// Whether a source reads a column without any value.
bool Describer::is_empty(std::string_view name) const {
  return std::ranges::any_of(readers_, [&](const auto& reader) {
    const auto column = std::ranges::find(result_.columns, reader.first, &DescribedColumn::name);
    return sources_[reader.second].name == name && column != result_.columns.end() &&
           column->missing == result_.rows;
  });
}

void Describer::add_lacks() {
  const auto has = [this](std::string_view name) {
    if (mapping_to(name, sources_) != nullptr) return !is_empty(name);
    // Four radii make a width.
    return name == "cw" && std::ranges::all_of(Names{"cr_e", "cr_w", "cr_s", "cr_n"},
                                               [this](const std::string& radius) {
                                                 return mapping_to(radius, sources_) != nullptr;
                                               });
  };
  for (const auto& [command, needs] : kNeeds) {
    LackingCommand lacking{.command = std::string(command)};
    for (const TreeColumn& column : tree_columns()) {
      const bool is_needed = has_word(needs, column.name);
      if (is_needed && !has(column.name)) lacking.lacks.emplace_back(column.name);
    }
    result_.commands.push_back(std::move(lacking));
  }
  for (const TreeColumn& column : tree_columns()) {
    if (has(column.name) || (column.makes_position() && has("x"))) continue;
    const Names likely = likely_columns(column.name, header());
    if (likely.empty()) continue;
    const std::string visits = pattern_of_visits(likely);
    note(fmt::format(
        "{0} may be {1}: `columns={0}={2}`{3}",
        column.name,
        fmt::join(likely, " or "),
        likely.front(),
        visits.empty() ? "" : fmt::format("; of all visits: `visits={}={}`", column.name, visits)));
  }
}

TableDescription Describer::run() {
  note(data::describe_layout(reader_.layout()));
  note(prepared_.note);
  find_sources();
  Names labels;
  for (const ColumnMapping& source : sources_) {
    if (!is_label(source.name)) continue;
    for (const auto& [column, reader] : readers_) {
      if (sources_[reader].name == source.name) labels.push_back(column);
    }
  }
  table_ = data::read_csv_table(
      reader_, {.text_columns = std::move(labels), .missing = options_.missing}, &codes_);
  result_.rows = table_.rows();
  data::take_missing_codes(table_, codes_);
  for (const std::string& column : table_.names()) describe(column);
  note(codes_.note());
  add_lacks();
  return std::move(result_);
}

}  // namespace

TableDescription describe_columns(const data::TableSource& source,
                                  const InventoryOptions& options) {
  return Describer(source, options).run();
}

std::vector<std::string> likely_columns(std::string_view name,
                                        const std::vector<std::string>& header) {
  constexpr std::size_t kLongEnough = 3;  // letters of a name that other letters may follow
  const TreeColumn* const column = tree_column(name);
  const auto is_named = [&](const std::string& word) {
    return word == folded_letters(name) || has_word(column->usual, word) ||
           has_word(column->vague, word);
  };
  std::vector<std::string> likely;
  for (const std::string& text : header) {
    const std::optional<MeantName> meant = meant_name(text);
    if (meant && meant->name != name) continue;
    const Names words = words_of(text);
    const bool begins = !words.empty() && name.size() >= kLongEnough &&
                        words.front().starts_with(folded_letters(name));
    if (meant || begins || std::ranges::any_of(words, is_named)) likely.push_back(text);
  }
  return likely;
}

std::string no_standard_column(const TreeColumn& column, const std::vector<std::string>& header) {
  const Names likely = likely_columns(column.name, header);
  const std::string visits = pattern_of_visits(likely);
  return fmt::format(
      "no column {0} ({1}) was found; {2}name it with `columns={0}={3}`{4}; available: {5}; "
      "`silvafit columns` shows how each column is read",
      column.name,
      column.meaning_with_unit(),
      likely.empty() ? "" : fmt::format("it may be {}; ", fmt::join(likely, " or ")),
      likely.empty() ? "COLUMN" : likely.front(),
      visits.empty() ? ""
                     : fmt::format(", or read all visits with `visits={}={}`", column.name, visits),
      data::list_of(header));
}

}  // namespace silvafit::stand
