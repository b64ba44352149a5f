// SPDX-License-Identifier: MIT
// Findings about structural units as counts, which can be added over parts of an inventory.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// Names of plots, of which only those that a note shows are kept.
class PlotNames {
 public:
  PlotNames() = default;
  explicit PlotNames(const std::vector<std::string>& names) { add(names); }
  void add(const std::vector<std::string>& names);
  void add(const PlotNames& others);
  bool empty() const { return shown_.empty(); }
  /// As data::list_of().
  std::string text() const;

 private:
  std::vector<std::string> shown_{};
  std::size_t more_ = 0;
};

/// Counts of trees and names of plots, of an inventory or of a part of one (whole plots).
struct UnitFindings {
  std::vector<std::string> on_windows{};     ///< notes on the assumed windows
  PlotNames plots_without_window{};          ///< their trees are on one line
  PlotNames plots_without_density{};         ///< the same; BAL and CCF are missing
  std::size_t plots_in_window_of_stand = 0;  ///< plots without a window of their own
  std::size_t placed = 0;                    ///< trees with a position and a window
  std::size_t outside = 0;                   ///< of these, outside of their window
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point high{-low.x, -low.y};  ///< the placed trees are between low and high
  PlotNames plots_outside{};   ///< plots whose trees are all outside
  /// Core trees whose competitors may be outside the window.
  std::size_t with_cut_competitors = 0;
  std::size_t without_position = 0;
  std::size_t with_few_neighbors = 0;
  std::size_t with_neighbor_at_place = 0;
  std::size_t without_crown_width = 0;  ///< or with a neighbor without crown width
  bool has_no_crown_widths = false;     ///< the inventory has no such column

  /// Adds another part, which comes later in the file.
  void add(const UnitFindings& part);
};

struct StructuralUnitOptions;

/// The findings as notes. Call it after all parts of an inventory (StructuralUnitOptions::is_part);
/// without parts structural_units does it.
/// \param options  that the units were computed with
/// \param file     for messages
/// \throws InputError if all trees are outside; UsageError if neighbors are searched within plots
///         and several plots share the stand's window
std::vector<std::string> notes_of(const UnitFindings& findings,
                                  const StructuralUnitOptions& options,
                                  const std::string& file);

}  // namespace silvafit::stand
