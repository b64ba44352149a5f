// SPDX-License-Identifier: MIT
#include "silvafit/tree/morphology_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "morphology/plot_choice.hpp"
#include "silvafit/base/enum_words.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/column_reference.hpp"

namespace silvafit::tree {
namespace {

using Numbers = std::vector<double>;

/// Cells with text instead of a number, by row, the first of each.
using UnreadableCells = std::map<std::size_t, data::TextCell>;

/// The sources of the standard columns in the table: "h" from "h_ols" or "BHD/10".
using SourceNames = std::map<std::string, std::string>;

class Columns {
 public:
  /// \param unreadable  receives the rows with unreadable cells
  /// \param names       receives the names of the sources
  Columns(const data::Table& table,
          const MorphologyTableOptions& options,
          UnreadableCells& unreadable,
          SourceNames& names)
      : table_(table), options_(options), unreadable_(unreadable), names_(names) {
    static const std::set<std::string> known{"plot",       "tree",
                                             "species",    "x",
                                             "y",          "z",
                                             "dbh",        "h",
                                             "hcb",        "cw",
                                             "cr_e",       "cr_w",
                                             "cr_s",       "cr_n",
                                             "hc",         "age",
                                             "bend_deg",   "bend_azimuth_deg",
                                             "internodes", "branch_angle_deg",
                                             "decay"};
    for (const auto& [name, expression] : options.columns) {
      if (!known.contains(name)) throw UsageError("grow does not use a column " + name);
    }
  }

  data::TextColumn labels(const std::string& name) const {
    const std::string column = required(mapped(name).value_or(name));
    names_[name] = column;
    return table_.labels(column);
  }

  std::optional<data::TextColumn> labels_if_any(const std::string& name) const {
    const std::string column = mapped(name).value_or(name);
    if (!mapped(name) && !table_.has(column)) return std::nullopt;
    return table_.labels(required(column));
  }

  Numbers numbers(const std::string& name, const std::string& suffix = "") const {
    const data::ColumnReference reference = reference_to(name, suffix);
    names_[name] = reference.text;
    std::vector<data::TextCell> cells;
    Numbers values = data::numbers_of(table_, reference, cells);
    const bool is_column = !reference.expression;
    if (is_column && !cells.empty() &&
        std::all_of(values.begin(), values.end(), [](double value) { return std::isnan(value); })) {
      throw InputError("contains text; numbers are needed",
                       {.file = table_.file(), .column = reference.text});
    }
    // Rows with such cells cannot be used.
    for (data::TextCell& cell : cells) unreadable_.emplace(cell.row, std::move(cell));
    return values;
  }

  std::optional<Numbers> numbers_if_any(const std::string& name,
                                        const std::string& suffix = "") const {
    if (!mapped(name) && !table_.has(name + suffix)) return std::nullopt;
    return numbers(name, suffix);
  }

 private:
  std::optional<std::string> mapped(const std::string& name) const {
    const auto found = options_.columns.find(name);
    if (found == options_.columns.end()) return std::nullopt;
    return found->second;
  }

  std::string required(const std::string& column) const {
    if (table_.has(column)) return column;
    const bool is_position = column == "x" || column == "y";
    throw InputError(
        is_position ? fmt::format("trees of one scene need positions, but there is no such column; "
                                  "name it with `columns={}=COLUMN`, or write each tree to a file "
                                  "of its own with `out`",
                                  column)
                    : "no such column; name the column with `columns`",
        {.file = table_.file(), .line = 1, .column = column});
  }

  data::ColumnReference reference_to(const std::string& name, const std::string& suffix) const {
    if (const auto text = mapped(name)) {
      return data::column_reference(name, *text, table_.names(), table_.file());
    }
    return {.text = required(name + suffix)};
  }

  const data::Table& table_;
  const MorphologyTableOptions& options_;
  UnreadableCells& unreadable_;
  SourceNames& names_;
};

/// All columns, read once.
struct Sources {
  data::TextColumn plot;
  data::TextColumn tree;
  std::optional<data::TextColumn> species, remains, assumed;
  std::optional<Numbers> x, y, z, cw, east, west, south, north, hc, age;
  std::optional<Numbers> bend, bend_azimuth, internodes, branch_angle;
  std::optional<Numbers> dbh, hcb, decay;
  Numbers h;
  UnreadableCells unreadable;
  SourceNames names;
};

Sources sources_of(const data::Table& table, const MorphologyTableOptions& options) {
  Sources from;
  const Columns columns(table, options, from.unreadable, from.names);
  const std::string suffix = options.use == Use::kObserved ? "" : "_" + word_of(options.use);
  from.plot = columns.labels("plot");
  from.tree = columns.labels("tree");
  from.species = columns.labels_if_any("species");
  from.h = columns.numbers("h", suffix);
  from.x = options.needs_position ? columns.numbers("x") : columns.numbers_if_any("x");
  from.y = options.needs_position ? columns.numbers("y") : columns.numbers_if_any("y");
  from.z = columns.numbers_if_any("z");
  if (options.only_height) return from;
  if (table.has(kAssumedColumn)) from.assumed = table.labels(kAssumedColumn);
  if (options.dead_wood) {
    from.remains = columns.labels_if_any("remains");
    from.decay = columns.numbers_if_any("decay");
  }
  from.dbh = columns.numbers("dbh");
  from.hcb = columns.numbers("hcb", suffix);
  if (options.use == Use::kObserved) {
    from.east = columns.numbers_if_any("cr_e");
    from.west = columns.numbers_if_any("cr_w");
    from.south = columns.numbers_if_any("cr_s");
    from.north = columns.numbers_if_any("cr_n");
    from.hc = columns.numbers_if_any("hc");
  }
  const bool has_radii = from.east && from.west && from.south && from.north;
  from.cw = has_radii ? columns.numbers_if_any("cw", suffix) : columns.numbers("cw", suffix);
  from.age = columns.numbers_if_any("age");
  from.bend = columns.numbers_if_any("bend_deg");
  from.bend_azimuth = columns.numbers_if_any("bend_azimuth_deg");
  from.internodes = columns.numbers_if_any("internodes");
  from.branch_angle = columns.numbers_if_any("branch_angle_deg");
  return from;
}

std::optional<double> value_if_known(const std::optional<Numbers>& column, std::size_t row) {
  if (!column || std::isnan((*column)[row])) return std::nullopt;
  return (*column)[row];
}

/// What is left of a tree, in small or capital letters; none for other words.
std::optional<Remains> remains_of(std::string_view text) {
  const std::string word = in_lower_case(text);
  if (word.empty() || word == "living") return Remains::kAll;
  return find_word<Remains>(word);
}

/// The missing label of a tree; empty: none.
std::string missing_label(const Sources& from, std::size_t row) {
  if (from.plot[row].empty()) return "plot";
  return from.tree[row].empty() ? "tree" : "";
}

/// None if one of the four is not known, or all are 0, which is a code of missing ones. A crown
/// that ends at the stem on one side reaches as far as the accuracy of the mesh.
std::optional<CrownRadii> radii_of(const Sources& from, std::size_t row) {
  constexpr double kAtStem = 0.01;
  const std::array columns{&from.east, &from.west, &from.south, &from.north};
  std::array<double, 4> radii{};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto radius = value_if_known(*columns[i], row);
    if (!radius) return std::nullopt;
    radii[i] = *radius;
  }
  if (std::ranges::count(radii, 0.0) == std::ssize(radii)) return std::nullopt;
  std::ranges::replace(radii, 0.0, kAtStem);
  return CrownRadii{radii[0], radii[1], radii[2], radii[3]};
}

Morphology morphology_of(const Sources& from, std::size_t row, bool needs_position) {
  Morphology tree;
  tree.plot = from.plot[row];
  tree.tree = from.tree[row];
  if (from.species) tree.species = (*from.species)[row];
  if (needs_position) tree.position = {(*from.x)[row], (*from.y)[row], 0.0};
  if (needs_position && from.z) tree.position.z_m = (*from.z)[row];
  if (from.assumed) tree.assumed = (*from.assumed)[row];
  tree.h_m = from.h[row];
  if (from.dbh) tree.dbh_cm = (*from.dbh)[row];
  if (from.hcb) tree.hcb_m = (*from.hcb)[row];
  tree.cw_m = value_if_known(from.cw, row);
  tree.hc_m = value_if_known(from.hc, row);
  tree.age_years = value_if_known(from.age, row);
  if (tree.age_years == 0.0) tree.age_years.reset();  // of a tree with a height it is a missing one
  tree.culm = {.bend_deg = value_if_known(from.bend, row),
               .bend_azimuth_deg = value_if_known(from.bend_azimuth, row),
               .internodes = value_if_known(from.internodes, row),
               .branch_angle_deg = value_if_known(from.branch_angle, row)};
  if (from.remains) tree.remains = remains_of((*from.remains)[row]).value_or(Remains::kAll);
  if (tree.remains == Remains::kSnag) tree.decay_class = value_if_known(from.decay, row);
  tree.radii = radii_of(from, row);
  return tree;
}

}  // namespace

MorphologyTable read_morphologies(const data::Table& table, const MorphologyTableOptions& options) {
  const Sources from = sources_of(table, options);
  require_plots(options.plots, from.plot, table.file());
  MorphologyTable result;
  std::set<std::pair<std::string, std::string>> seen;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Morphology tree = morphology_of(from, row, options.needs_position);
    const auto& plots = options.plots;
    if (!plots.empty() && std::find(plots.begin(), plots.end(), tree.plot) == plots.end()) continue;
    Place place{
        .file = table.file(), .line = table.line(row), .plot = tree.plot, .tree = tree.tree};
    if (const std::string label = missing_label(from, row); !label.empty()) {
      place.column = from.names.at(label);
      result.left_out.push_back({place, "is missing"});
      continue;
    }
    if (const auto cell = from.unreadable.find(row); cell != from.unreadable.end()) {
      place.column = cell->second.column;
      result.left_out.push_back({place, "'" + cell->second.text + "' is not a number"});
      continue;
    }
    if (from.remains && !remains_of((*from.remains)[row])) {
      place.column = "remains";
      result.left_out.push_back(
          {place, "'" + std::string((*from.remains)[row]) + "' is not snag, stump, log or living"});
      continue;
    }
    try {
      options.only_height ? validate_height(tree) : validate(tree);
    } catch (const DomainError& error) {
      const auto source = from.names.find(error.place().column);
      place.column = source == from.names.end() ? error.place().column : source->second;
      result.left_out.push_back({place, error.message()});
      continue;
    }
    if (!seen.emplace(tree.plot, tree.tree).second) {
      result.left_out.push_back({place, "the plot has another tree with this label"});
      continue;
    }
    result.morphologies.push_back(std::move(tree));
  }
  return result;
}

}  // namespace silvafit::tree
