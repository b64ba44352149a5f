// SPDX-License-Identifier: MIT
#include "silvafit/stand/unread_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "silvafit/base/text.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/stand/tree_status.hpp"
#include "trees/column_sources.hpp"
#include "trees/folded_text.hpp"
#include "trees/status_words.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {
namespace {

using Names = std::vector<std::string>;

constexpr std::string_view kDigits = "0123456789";

/// The name of a column in folded letters, without its unit.
std::string letters_of(const std::string& column) {
  return folded_letters(header_parts(column).name);
}

/// The standard column whose name a header has before a number; empty if it has another form.
std::string_view numbered_name(const std::string& column) {
  if (meant_name(column)) return {};
  const std::string letters = letters_of(column);
  const std::size_t end = letters.find_last_not_of(kDigits);
  if (end == std::string::npos || end + 1 == letters.size()) return {};
  const auto meant = meant_name(letters.substr(0, end + 1));
  return meant ? meant->name : std::string_view();
}

/// The columns of a standard column, unless the user computes it of others.
std::optional<std::string> column_read_as(const std::string& name,
                                          const Names& header,
                                          const std::vector<ColumnMapping>& mapped,
                                          const std::string& file) {
  const ColumnMapping* const mapping = mapping_to(name, mapped);
  if (mapping != nullptr && !field_named(mapping->source, header)) return std::nullopt;
  const std::vector<std::size_t> fields = fields_of(name, header, mapped, file);
  if (fields.size() == 1) return header[fields.front()];
  // Circumferences are converted.
  const auto circumference = std::ranges::find_if(header, [&name](const std::string& column) {
    const auto meant = meant_name(column);
    return meant && meant->name == name && meant->fit == NameFit::kConverted;
  });
  const bool is_read = circumference != header.end() && mapping == nullptr;
  return is_read ? std::optional(*circumference) : std::nullopt;
}

/// The column as an expression for a standard column.
std::string expression_of(const std::string& column, const std::string& like) {
  const auto meant = meant_name(like);
  const bool is_converted = meant && meant->fit == NameFit::kConverted;
  return data::Expression::variable(column).text() +
         (is_converted ? std::string(meant->conversion) : std::string());
}

/// Radii between the four directions, named as the one to the north is.
Names radii_between(const Names& header, const std::string& north) {
  const std::string letters = letters_of(north);
  for (const std::string_view direction : {"north", "nord", "norte", "n"}) {
    if (!letters.ends_with(direction)) continue;
    const std::string stem = letters.substr(0, letters.size() - direction.size());
    Names found;
    for (const std::string& column : header) {
      const std::string other = letters_of(column);
      const bool is_between = other.starts_with(stem) &&
                              has_word(
                                  "ne nw se sw no so northeast northwest southeast southwest "
                                  "nordost nordwest sudost sudwest noreste noroeste sureste "
                                  "suroeste",
                                  std::string_view(other).substr(stem.size()));
      if (is_between) found.push_back(column);
    }
    return found;
  }
  return {};
}

/// The fields whose folded letters are one of the words.
std::vector<std::size_t> fields_named(std::string_view words, const Names& header) {
  std::vector<std::size_t> fields;
  for (std::size_t field = 0; field < header.size(); ++field) {
    const std::string letters = folded_letters(header[field]);
    if (!letters.empty() && has_word(words, letters)) fields.push_back(field);
  }
  return fields;
}

}  // namespace

std::string describe_unread_columns(const Names& header,
                                    const std::vector<ColumnMapping>& mapped,
                                    const std::string& file) {
  const auto is_read = [&mapped](const std::string& column) {
    return std::ranges::any_of(mapped, [&column](const ColumnMapping& mapping) {
      return mapping.source.find(column) != std::string::npos;
    });
  };
  Names notes;
  for (const std::string name : {"dbh", "h", "hcb", "cw"}) {
    const auto read = column_read_as(name, header, mapped, file);
    if (!read) continue;
    Names further;
    std::ranges::copy_if(header, std::back_inserter(further), [&](const std::string& column) {
      return column != *read && numbered_name(column) == name && !is_read(column);
    });
    if (further.empty()) continue;
    notes.push_back(
        fmt::format("{0} is read from {1}, not from {2}; if that is another visit, read it with "
                    "`columns={0}={3}`",
                    name,
                    *read,
                    data::list_of(further),
                    expression_of(further.back(), *read)));
    // dbh_2019 is another visit.
    const auto has_year = [](const std::string& column) {
      const std::size_t end = column.find_last_not_of(kDigits) + 1;
      return column.size() - end == 4;
    };
    if (name != "dbh" || has_year(further.front())) continue;
    notes.back() += fmt::format(
        "; if it is another stem of the tree, `columns=dbh=sqrt(({})^2 + ({})^2)` has the basal "
        "area of both, with 0 for trees that have none",
        expression_of(*read, *read),
        expression_of(further.front(), *read));
  }
  if (const auto north = column_read_as("cr_n", header, mapped, file)) {
    Names between = radii_between(header, *north);
    std::erase_if(between, is_read);
    if (!between.empty()) {
      notes.push_back(
          fmt::format("crowns have the radii to the north, east, south and west; {} {} "
                      "not read",
                      data::list_of(between),
                      between.size() == 1 ? "is" : "are"));
    }
  }
  return fmt::format("{}", fmt::join(notes, "; "));
}

std::vector<std::size_t> fields_of_units(const Names& header) {
  constexpr std::string_view kNames =
      "stand standid standno standnr standnumber bestand bestandnr bestandsnr bestandesnr "
      "abteilung unterabteilung cluster clusterid clusterno clusternr trakt traktid traktnr tract "
      "tractid forest forestid site siteid sitename region block blockid compartment district "
      "farm finca peuplement foret conglomerado rodal talhao bosque metsikko kuvio lohko bestand "
      "avdelning oddzial porost 林分 林班 小班";
  return fields_named(kNames, header);
}

/// Positions and numbers of trees are different in each row, and other columns of many different
/// texts are names: neither has words of the status.
bool StatusWords::is_given_up() const {
  constexpr std::size_t kMostNumbers = 1000;
  constexpr std::size_t kMostTexts = 20000;
  return numbers_ == values_.size() ? numbers_ >= kMostNumbers : values_.size() >= kMostTexts;
}

StatusWords::StatusWords(std::string column) : column_(std::move(column)) {
  if (const auto of_header = status_of_header(column_)) if_true_ = of_header->status;
}

StatusWords::Entry* StatusWords::find(std::string_view value) {
  const bool has_only_numbers = numbers_ == values_.size();
  if (value.empty() || (has_only_numbers && is_given_up())) return nullptr;
  auto known = values_.find(value);
  if (known == values_.end()) {
    if (is_given_up()) return nullptr;
    double ignored = 0.0;
    const bool is_number = data::parse_number(value, ignored);
    const auto kind = if_true_ ? StatusText::kStatus : StatusText::kAny;
    const auto status = is_number ? std::nullopt : status_in(value, kind);
    if (is_number) ++numbers_;
    bool is_gone = status && *status != TreeStatus::kAlive;
    if (if_true_) {
      const auto answer = answer_in(value);
      if (!answer && !status) ++others_;
      is_gone = is_gone || (answer && *answer != (*if_true_ == TreeStatus::kAlive));
    }
    known = values_.emplace(std::string(value), Value{.is_gone = is_gone}).first;
  }
  return &*known;
}

void StatusWords::count(Entry& entry, bool has_dbh, std::size_t rows) {
  (has_dbh ? entry.second.with_dbh : entry.second.without_dbh) += rows;
  if (!entry.second.is_gone) return;
  if (rows_ == 0) first_ = entry.first;
  rows_ += rows;
}

void StatusWords::add(const data::TextColumn& values) {
  std::vector<std::size_t> rows(values.levels().size());
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (!values.is_missing(row)) ++rows[values.code(row)];
  }
  for (std::size_t code = 0; code < rows.size(); ++code) {
    if (rows[code] > 0) add(values.levels()[code], rows[code]);
  }
}

std::string StatusWords::note() const {
  // Lengths of stumps and years of harvests are no answers.
  if (rows_ == 0 || others_ > 0) return {};
  return fmt::format(
      "{} a word of dead or cut trees in column {} ({}) and {} as living; to read "
      "it as their status, use `columns=status={}`",
      counted(rows_, "row has", "rows have"),
      column_,
      first_,
      rows_ == 1 ? "counts" : "count",
      data::Expression::variable(column_).text());
}

std::string StatusWords::note_without_dbh(std::size_t trees) const {
  std::size_t rows = 0;
  Names codes;
  for (const auto& [value, counts] : values_) {
    if (counts.without_dbh == 0 || counts.with_dbh > 0) continue;
    rows += counts.without_dbh;
    codes.push_back(value);
  }
  // Words have their own note.
  if (rows_ > 0 || 2 * rows <= trees) return {};
  return fmt::format(
      "of {} without a dbh that count as living, {} {} {} in column {}, which no tree with a dbh "
      "has; if these are dead or cut, use `columns=status={}` with `dead_codes` or `cut_codes`",
      counted(trees, "row", "rows"),
      rows,
      rows == 1 ? "has" : "have",
      data::list_of(codes),
      column_,
      data::Expression::variable(column_).text());
}

}  // namespace silvafit::stand
