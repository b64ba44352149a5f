// SPDX-License-Identifier: MIT
#include "trees/shared_plot_labels.hpp"

#include <fmt/format.h>

#include <iterator>

#include "silvafit/base/text.hpp"

namespace silvafit::stand {

void SharedPlotLabels::add(std::string_view plot, std::string_view stand) {
  // Most rows are of the same plot as the one before.
  if (!stand_of_plot_.empty() && plot == last_plot_ && stand == last_stand_) return;
  last_plot_ = plot;
  last_stand_ = stand;
  const auto [known, is_new] = stand_of_plot_.try_emplace(last_plot_, stand);
  if (is_new || known->second == stand) return;
  shared_.try_emplace(last_plot_, Shared{.first = known->second, .other = std::string(stand)});
}

void SharedPlotLabels::finish_plots() {
  stand_of_plot_.clear();
  while (shared_.size() > 1) {
    shared_.erase(std::prev(shared_.end()));
    ++forgotten_;
  }
}

std::optional<SharedPlotLabels::Example> SharedPlotLabels::first() const {
  if (shared_.empty()) return std::nullopt;
  const auto& [label, stands] = *shared_.begin();
  return Example{.label = label, .first = stands.first, .other = stands.other};
}

std::string SharedPlotLabels::note_on_visits() const {
  if (shared_.empty()) return {};
  const auto& [place, plots] = *shared_.begin();
  return fmt::format(
      "{} visited several times ({} has the plots {} and {}), and each visit counts as a plot; "
      "choose one visit of each with `where`",
      counted(forgotten_ + shared_.size(), "place was", "places were"),
      place,
      plots.first,
      plots.other);
}

std::string SharedPlotLabels::note(const std::string& column) const {
  if (shared_.empty()) return {};
  const auto& [plot, stands] = *shared_.begin();
  return fmt::format(
      "{} several values of the column {} ({} occurs with {} and {}), but all trees with one plot "
      "label are treated as one plot; use plot labels that are unique in the file, such as {}-{}",
      counted(forgotten_ + shared_.size(), "plot label occurs with", "plot labels occur with"),
      column,
      plot,
      stands.first,
      stands.other,
      stands.first,
      plot);
}

}  // namespace silvafit::stand
