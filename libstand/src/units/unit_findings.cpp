// SPDX-License-Identifier: MIT
#include "silvafit/stand/unit_findings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "units/edge.hpp"

namespace silvafit::stand {
namespace {

void refuse_all_outside(const UnitFindings& findings, const std::string& file) {
  if (findings.outside == 0 || findings.outside < findings.placed) return;
  throw InputError(fmt::format("all trees are outside the window; they are between x {} and {}, y "
                               "{} and {} m. Check that the window has the same coordinates",
                               findings.low.x,
                               findings.high.x,
                               findings.low.y,
                               findings.high.y),
                   {.file = file});
}

void note_trees(const UnitFindings& findings,
                std::size_t neighbors,
                std::vector<std::string>& notes) {
  const auto note = [&notes](std::size_t count, std::string_view what) {
    if (count == 0) return;
    notes.push_back(fmt::format("{} {}", counted(count, "tree has", "trees have"), what));
  };
  note(findings.without_position, "no position and therefore no structural unit");
  note(findings.with_few_neighbors,
       fmt::format("fewer than {} neighbors and therefore no indices", neighbors));
  note(findings.with_neighbor_at_place,
       "a neighbor at the same position, which has no direction; W is missing");
  note(findings.without_crown_width,
       "no crown width, or a neighbor without crown width; C is missing");
  if (findings.has_no_crown_widths) notes.emplace_back("no crown widths; C is missing");
}

}  // namespace

void PlotNames::add(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 40;
  for (const std::string& name : names) {
    if (shown_.size() < kShown) {
      shown_.push_back(name);
    } else {
      ++more_;
    }
  }
}

void PlotNames::add(const PlotNames& others) {
  add(others.shown_);
  more_ += others.more_;
}

std::string PlotNames::text() const {
  const std::string list = data::list_of(shown_);
  return more_ == 0 ? list : fmt::format("{} and {} more", list, more_);
}

void UnitFindings::add(const UnitFindings& part) {
  for (const std::string& note : part.on_windows) {
    if (std::ranges::find(on_windows, note) == on_windows.end()) on_windows.push_back(note);
  }
  plots_without_window.add(part.plots_without_window);
  plots_without_density.add(part.plots_without_density);
  plots_in_window_of_stand += part.plots_in_window_of_stand;
  placed += part.placed;
  outside += part.outside;
  low = {std::min(low.x, part.low.x), std::min(low.y, part.low.y)};
  high = {std::max(high.x, part.high.x), std::max(high.y, part.high.y)};
  plots_outside.add(part.plots_outside);
  with_cut_competitors += part.with_cut_competitors;
  without_position += part.without_position;
  with_few_neighbors += part.with_few_neighbors;
  with_neighbor_at_place += part.with_neighbor_at_place;
  without_crown_width += part.without_crown_width;
  has_no_crown_widths = has_no_crown_widths || part.has_no_crown_widths;
}

std::vector<std::string> notes_of(const UnitFindings& findings,
                                  const StructuralUnitOptions& options,
                                  const std::string& file) {
  if (options.scope == SearchScope::kPlot) {
    refuse_shared_window(findings.plots_in_window_of_stand);
  }
  if (!options.sampled) refuse_all_outside(findings, file);
  std::vector<std::string> notes = findings.on_windows;
  if (!findings.plots_without_window.empty()) {
    notes.push_back(fmt::format("{}, so there is no core tree in: {}",
                                options.sampled ? "no circle of complete neighborhoods is known"
                                                : "trees on one line have no convex hull",
                                findings.plots_without_window.text()));
  }
  if (!findings.plots_without_density.empty()) {
    notes.push_back(fmt::format(
        "trees on one line have no area, so indices per hectare (BAL, CCF) are missing in: {}",
        findings.plots_without_density.text()));
  }
  if (findings.outside > 0 && !options.sampled) {
    notes.push_back(outside_note(findings.outside, options.edge));
  }
  if (!findings.plots_outside.empty()) {
    const std::string plots = findings.plots_outside.text();
    notes.push_back(
        options.sampled
            ? "no tree is within the circle of complete neighborhoods of plot " + plots
            : fmt::format("all trees are outside the window of plot {}; check that it has the same "
                          "coordinates",
                          plots));
  }
  if (findings.with_cut_competitors > 0) {
    notes.push_back(
        fmt::format("competitors of {} core trees may be outside the window (`competition_radius` "
                    "is {} m), so their Hegyi index is too small; use a `buffer` of that width",
                    findings.with_cut_competitors,
                    options.competition_radius_m));
  }
  note_trees(findings, options.neighbors, notes);
  return notes;
}

}  // namespace silvafit::stand
