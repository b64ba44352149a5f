// SPDX-License-Identifier: MIT
// What growth leaves out, and what is odd about the trees that were followed.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "growth/growth_maker.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/table.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {

void GrowthMaker::note_missing() {
  for (std::size_t i = 0; i < missing_.size(); ++i) {
    if (missing_[i].empty()) continue;
    report_.notes.push_back(fmt::format(
        "{} no value at the start or end of a period and {} left out of both sums of {}: {}",
        counted(missing_[i].size(), "tree has", "trees have"),
        missing_[i].size() == 1 ? "is" : "are",
        report_.values[i],
        data::list_of(missing_[i])));
  }
}

void GrowthMaker::note_moved() {
  std::vector<Survivors> survivors;
  for (const Period& period : periods_) {
    Survivors& rows = survivors.emplace_back();
    for (const TreeInPeriod& tree : period.trees) {
      if (tree.start != kNoTreeRow && tree.end != kNoTreeRow)
        rows.emplace_back(tree.start, tree.end);
    }
  }
  std::string moved = describe_moved_trees(living_, survivors);
  if (!moved.empty()) report_.notes.push_back(std::move(moved));
}

void GrowthMaker::note_uncounted() {
  std::vector<std::string> places;
  for (std::size_t row = 0; row < living_.size(); ++row) {
    if (is_counted_[row] == 0)
      places.push_back(fmt::format("plot {}, tree {}", living_.plot[row], living_.tree[row]));
  }
  if (places.empty()) return;
  report_.notes.push_back(
      fmt::format("{} outside of the window of the plot, or {} no position, and {} not counted: {}",
                  counted(places.size(), "row of a living tree is", "rows of living trees are"),
                  places.size() == 1 ? "has" : "have",
                  places.size() == 1 ? "is" : "are",
                  data::list_of(places)));
}

void GrowthMaker::note_if(std::size_t count, const std::string& text) {
  if (count > 0) report_.notes.push_back(text);
}

/// Periods whose length is known to a year only, although one end is a date.
void GrowthMaker::note_years_beside_dates() {
  std::vector<std::string> mixed;
  for (const Period& period : periods_) {
    const MeasuredPlot& plot = plots_[period.plot];
    const Occasion& from = plot.occasions[period.occasion];
    const Occasion& to = plot.occasions[period.occasion + 1];
    if (is_year(from.years) == is_year(to.years)) continue;
    mixed.push_back(fmt::format("plot {} ({} to {})", plot.plot, from.text, to.text));
  }
  note_if(mixed.size(),
          fmt::format("{} between a year and a date; a year counts as its 1 January, so that "
                      "values per year may be wrong by those of a year: {}",
                      counted(mixed.size(), "period is", "periods are"),
                      data::list_of(mixed)));
}

void GrowthMaker::add_notes() {
  note_missing();
  note_years_beside_dates();
  std::size_t not_found = 0;
  std::string first_lost;
  for (const TreeGrowth& tree : report_.trees) {
    if (tree.fate == TreeFate::kNotFound && not_found++ == 0) {
      first_lost = fmt::format("plot {}, tree {}, {}", tree.plot, tree.tree, tree.to);
    }
  }
  note_if(not_found,
          fmt::format("{} no row at the end of a period and no status of death or cut: 'not "
                      "found', the first: {}",
                      counted(not_found, "tree has", "trees have"),
                      first_lost));
  note_if(
      interpolated_.size(),
      fmt::format("{} missing between two others of the same tree; dbh and height are interpolated",
                  counted(interpolated_.size(), "measurement is", "measurements are")));
  note_if(carried_,
          fmt::format("{} no dbh before the tree died, was cut or was not found: the one before "
                      "is used",
                      counted(carried_, "row has", "rows have")));
  note_if(revived_,
          fmt::format("{} not used, the first: {}",
                      counted(revived_, "status is", "statuses are"),
                      first_revived_));
  note_if(never_alive_,
          fmt::format("{} not alive at any time and {} no growth",
                      counted(never_alive_, "tree was", "trees were"),
                      never_alive_ == 1 ? "has" : "have"));
  note_if(renamed_.size(),
          fmt::format("{} another species at the end of a period and {} for the first one: {}",
                      counted(renamed_.size(), "tree has", "trees have"),
                      renamed_.size() == 1 ? "counts" : "count",
                      data::list_of(renamed_)));
  note_odd_increments();
  note_thick_ingrowth();
}

/// Ingrowth was below the smallest dbh of the start, and grew no more than the fastest survivor.
void GrowthMaker::note_thick_ingrowth() {
  double smallest_cm = std::numeric_limits<double>::infinity();
  double fastest = 0.0;
  for (const TreeGrowth& tree : report_.trees) {
    if (tree.dbh_start_cm > 0.0) smallest_cm = std::min(smallest_cm, tree.dbh_start_cm);
    if (tree.dbh_cm_per_year > fastest) fastest = tree.dbh_cm_per_year;
  }
  if (!(fastest > 0.0)) return;
  std::vector<std::string> thick;
  for (const TreeGrowth& tree : report_.trees) {
    const double most_cm = smallest_cm + fastest * tree.years;
    if (tree.fate != TreeFate::kIngrowth || !(tree.dbh_end_cm > most_cm)) continue;
    thick.push_back(fmt::format(
        "plot {}, tree {} ({} cm, {})", tree.plot, tree.tree, tree.dbh_end_cm, tree.to));
  }
  note_if(thick.size(),
          fmt::format("{} thicker than the smallest dbh before, {} cm, with the largest increment, "
                      "{:.2g} cm per year, and may have been missed then: {}",
                      counted(thick.size(), "ingrowth tree is", "ingrowth trees are"),
                      smallest_cm,
                      fastest,
                      data::list_of(thick)));
}

/// Increments that are negative, or larger than trees have.
void GrowthMaker::note_odd_increments() {
  std::vector<std::string> shrunk;
  std::vector<std::string> too_fast;
  std::vector<std::string> too_thin;
  for (const TreeGrowth& tree : report_.trees) {
    const bool is_shrunk = tree.dbh_cm_per_year < 0.0;
    if (!is_shrunk && !(tree.dbh_cm_per_year > kFastestCmPerYear)) continue;
    const bool is_too_thin = tree.dbh_end_cm < (1.0 - kLargestLoss) * tree.dbh_start_cm;
    std::vector<std::string>& list = is_too_thin ? too_thin : is_shrunk ? shrunk : too_fast;
    list.push_back(fmt::format("plot {}, tree {} ({} to {} cm, {} to {})",
                               tree.plot,
                               tree.tree,
                               tree.dbh_start_cm,
                               tree.dbh_end_cm,
                               tree.from,
                               tree.to));
  }
  note_if(too_fast.size(),
          fmt::format("{} above {} cm per year, more than any tree grows, and kept: {}",
                      counted(too_fast.size(), "dbh increment is", "dbh increments are"),
                      kFastestCmPerYear,
                      data::list_of(too_fast)));
  note_if(too_thin.size(),
          fmt::format("{} more than {:g} % of its dbh and {} for the same one: the number seems to "
                      "be another tree's, which changes survivor growth, ingrowth and losses: {}",
                      counted(too_thin.size(), "tree lost", "trees lost"),
                      100.0 * kLargestLoss,
                      too_thin.size() == 1 ? "counts" : "count",
                      data::list_of(too_thin)));
  const bool are_most = 2 * shrunk.size() > report_.trees.size();
  note_if(shrunk.size(),
          fmt::format("{} negative and kept: errors of measurement, or bark that was lost{}: {}",
                      counted(shrunk.size(), "dbh increment is", "dbh increments are"),
                      are_most ? "; that is most of them: check the times" : "",
                      data::list_of(shrunk)));
}

}  // namespace silvafit::stand
