// SPDX-License-Identifier: MIT
// How an inventory was read, and what was assumed or left out.
#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/expression.hpp"
#include "trees/inventory_reader.hpp"

namespace silvafit::stand {

std::string InventoryReader::note_on_dead() const {
  if (!plan_.status_field) return {};
  std::string text =
      fmt::format("the status of trees is read from column {}: {} dead, {} cut or gone",
                  status_.header(),
                  status_.dead(),
                  status_.gone());
  const bool has_dead = status_.dead() > 0;
  if (options_.dead == DeadTrees::kInclude) {
    text += ", all used as living trees";
  } else if (options_.keeps_measurements) {
    text += ", which are mortality and cut at the end of a period";
  } else if (options_.dead == DeadTrees::kNeighbors && has_dead) {
    text += "; dead trees are neighbors only, the others are skipped";
  } else if (has_dead || status_.gone() > 0) {
    text += ", skipped";
    if (has_dead) text += "; with `dead=neighbors`, dead trees count as neighbors";
  }
  return text + status_.remarks();
}

std::string InventoryReader::note_on_empty_plots() const {
  if (!has_run_of_empty_plots_) return {};
  return fmt::format("{} empty, as in merged cells; with `fill_down=plot`, the value above is used",
                     counted(empty_plots_, "row has a plot that is", "rows have a plot that is"));
}

std::vector<std::string> InventoryReader::recognized() const {
  std::vector<std::string> texts{data::describe_layout(csv_.layout()),
                                 prepared_.note,
                                 describe_usual_columns(plan_.usual, csv_.header()),
                                 codes_.note()};
  texts.push_back(spellings_.note());
  texts.push_back(note_on_dead());
  texts.push_back(describe_unread_columns(csv_.header(), options_.columns, file_));
  for (const StatusWords& column : unread_) {
    texts.push_back(column.note());
    if (without_dbh_ > 0 && !plan_.status_field) {
      texts.push_back(column.note_without_dbh(without_dbh_));
    }
  }
  std::erase(texts, "");
  return texts;
}

/// Numbers of trees that begin again for most rows are those of several plots or times.
void InventoryReader::refuse_plots_without_column() const {
  const std::size_t trees = result_.inventory.size();
  if (plan_.labels[kPlot].exists() || 2 * repeated_numbers_.renamed < trees) return;
  throw InputError(
      fmt::format(
          "{} of {} trees have the number of another tree, but there is no column plot; name "
          "it with `columns=plot=COLUMN`, or the time with `columns=year=COLUMN`; "
          "available: {}",
          repeated_numbers_.renamed,
          trees,
          data::list_of(csv_.header())),
      {.file = result_.inventory.file});
}

/// Numbers of trees are whole and mostly above 1, and 0 is one of no tree. Where trees have no
/// numbers of their own, or the column names trees, any other number than 1 is one.
void InventoryReader::refuse_tally() const {
  const bool may_be_of_stems = plan_.labels[kTree].exists() && !plan_.tally_counts_trees;
  const bool is_tally =
      may_be_of_stems ? 2 * tally_several_ > tally_rows_ || tally_none_ > 0 : tally_others_ > 0;
  if (!plan_.tally_field || !is_tally) return;
  const std::string& name = csv_.header()[*plan_.tally_field];
  throw InputError(
      fmt::format("the column {} may be the number of trees of each row, but a row is one tree: "
                  "give the trees per hectare of a row with `expansion`, such as "
                  "`columns=each={}*10000/AREA` and `expansion=each`; {}if a row is one tree, use "
                  "`trust_units=true`",
                  name,
                  data::Expression::variable(name).text(),
                  plan_.labels[kTree].exists()
                      ? std::string()
                      : fmt::format("if it numbers the trees, use `columns=tree={}`; ", name)),
      {.file = file_, .column = name});
}

/// Trees of several genera would be counted as one species.
void InventoryReader::refuse_epithets() const {
  const auto shared = genera_of_species_.first();
  if (!shared) return;
  const std::string& genus = csv_.header()[*plan_.genus_field];
  const std::string& species = plan_.labels[kSpecies].text;
  throw InputError(
      fmt::format("'{}' occurs with the genera {} and {}: it is no species alone; join both with "
                  "`columns=species={} + \" \" + {}`",
                  shared->label,
                  shared->first,
                  shared->other,
                  data::Expression::variable(genus).text(),
                  data::Expression::variable(species).text()),
      {.file = file_, .column = species});
}

std::vector<std::string> InventoryReader::notes() const {
  std::vector<std::string> notes = recognized();
  std::string empty_plots = note_on_empty_plots();
  if (!empty_plots.empty()) notes.push_back(std::move(empty_plots));
  for (std::string& note : repeated_numbers_.notes()) notes.push_back(std::move(note));
  if (!plan_.labels[kPlot].exists()) {
    std::vector<std::string> units;
    for (const std::size_t field : plan_.unit_fields) units.push_back(csv_.header()[field]);
    notes.push_back(fmt::format("no column plot: all trees are in one plot, '{}'{}",
                                kOnlyPlot,
                                units.empty() ? ""
                                              : fmt::format("; if {} names the plots, use "
                                                            "`columns=plot={}`",
                                                            data::list_of(units),
                                                            units.front())));
  }
  if (!plan_.labels[kTree].exists()) {
    notes.emplace_back("no column tree: trees are numbered by row");
  }
  if (!plan_.labels[kSpecies].exists()) {
    notes.push_back(
        fmt::format("no column species: all trees have one species, '{}'", kOnlySpecies));
  }
  for (std::size_t i = 0; i < shared_labels_.size() && plan_.labels[kPlot].exists(); ++i) {
    std::string note = shared_labels_[i].note(csv_.header()[plan_.unit_fields[i]]);
    if (!note.empty()) notes.push_back(std::move(note));
  }
  if (std::string note = plots_of_locations_.note_on_visits(); !note.empty()) {
    notes.push_back(std::move(note));
  }
  if (has_cw_from_radii_) {
    notes.emplace_back("cw is computed from the four crown radii where it is missing");
  }
  if (other_widths_ > 0) {
    notes.push_back(
        fmt::format("{} a cw that contradicts the four radii, which make more than twice or less "
                    "than half of it ({}); cover and crowding use cw, and drawn crowns the radii",
                    counted(other_widths_, "tree has", "trees have"),
                    first_other_width_));
  }
  if (without_dbh_ > 0) {
    notes.push_back(
        options_.keeps_measurements
            ? counted(without_dbh_,
                      "row of a living tree has no dbh",
                      "rows of living trees have no dbh")
            : fmt::format("{} without dbh: neighbors of others, but not core trees, and not "
                          "in summaries and models",
                          counted(without_dbh_, "tree is", "trees are")));
  }
  if (without_species_ > 0)
    notes.push_back(counted(without_species_, "tree has no species", "trees have no species"));
  for (std::string& note : odd_values_.notes()) notes.push_back(std::move(note));
  return notes;
}

void InventoryReader::refuse_empty(const std::string& excluded) const {
  if (row_count_ == 0) throw InputError("the file has a header but no trees", {.file = file_});
  throw InputError("no usable row: " + (excluded.empty() ? note_on_dead() : excluded),
                   {.file = file_});
}

void InventoryReader::require_trees() const {
  if (!has_trees_) refuse_empty(excluded());
}

}  // namespace silvafit::stand
