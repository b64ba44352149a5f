// SPDX-License-Identifier: MIT
// Repeated measurements, sorted: plots, their times, the rows of each tree at each time, and the
// living trees of all times.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/plot_table.hpp"

namespace silvafit::stand {

/// A time at which a plot was measured.
struct Occasion {
  double years = 0.0;  ///< of several days the mean of the trees
  std::string text{};  ///< of several days the first
  double first = 0.0;  ///< day, in years; that of `years` for one day
  double last = 0.0;
};

/// A tree at the occasions of its plot.
struct MeasuredTree {
  std::string tree{};
  std::vector<std::optional<std::size_t>> rows{};  ///< of the inventory, by occasion
};

struct MeasuredPlot {
  std::string plot{};
  std::vector<Occasion> occasions{};  ///< by time
  std::vector<MeasuredTree> trees{};  ///< in the order of their first rows
};

/// Sorts an inventory. Days of one campaign on which no tree was measured twice are one visit, as
/// for stands. Times of the table of plots are included, so that plots that have become
/// empty, or were empty, have their periods; plots without trees and time have those of the others.
/// \param plots  with_times_read(), or null
/// \param notes  gets how dates such as 5/6/2019 were read
/// \throws InputError if there is no time, a time is not a year or date, or the times of a plot
///   without trees are unknown
std::vector<MeasuredPlot> measured_plots(const Inventory& inventory,
                                         const PlotTable* plots,
                                         std::vector<std::string>& notes);

/// A table of plots in which dates such as 5/6/2019 have the year first.
/// \throws as ColumnTimes::read
PlotTable with_times_read(PlotTable plots, std::vector<std::string>& notes);

/// The occasion of a time; a year matches any date in it, and the other way round. None if there
/// is no such occasion.
std::optional<std::size_t> occasion_at(const MeasuredPlot& plot, const std::string& time);

/// The living trees of all times as an inventory in which each plot and time is a plot, so that
/// areas, designs and expansion factors are those of any inventory.
class LivingTrees {
 public:
  explicit LivingTrees(const Inventory& source) : source_(source) {}

  /// \param is_measured  whether the sizes of the row are those of this time, else unknown
  /// \return the number of the row
  std::size_t add(std::size_t row, const std::string& label, bool is_measured = true);
  /// Sizes that are unknown between two known ones of a tree are on the line between these.
  /// \param rows       of one tree, in the order of their times
  /// \param years      of the rows
  /// \param has_ended  whether later unknown sizes are the last known ones
  /// \return the rows that have got a dbh
  std::vector<std::size_t> complete(const std::vector<std::size_t>& rows,
                                    const std::vector<double>& years,
                                    bool has_ended);
  Inventory finish() &&;

 private:
  const Inventory& source_;
  std::vector<std::size_t> rows_{};
  Inventory result_{};
};

}  // namespace silvafit::stand
