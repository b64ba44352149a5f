// SPDX-License-Identifier: MIT
#include "inventory_shared_labels.hpp"

#include <fmt/format.h>

#include "silvafit/base/text.hpp"

namespace silvafit::stand {

void SharedPlotLabels::add(std::string_view plot, std::string_view stand) {
  // Most rows are of the same plot as the one before.
  if (!stand_of_plot_.empty() && plot == last_plot_ && stand == last_stand_) return;
  last_plot_ = plot;
  last_stand_ = stand;
  const auto [known, is_new] = stand_of_plot_.try_emplace(last_plot_, stand);
  if (!is_new && known->second != stand) other_stand_.try_emplace(last_plot_, stand);
}

std::string SharedPlotLabels::note(const std::string& column) const {
  if (other_stand_.empty()) return {};
  const auto& [plot, other] = *other_stand_.begin();
  const std::string& first = stand_of_plot_.at(plot);
  return fmt::format(
      "{} several values of the column {} ({} occurs with {} and {}), but all trees with one plot "
      "label are treated as one plot; use plot labels that are unique in the file, such as {}-{}",
      counted(other_stand_.size(), "plot label occurs with", "plot labels occur with"),
      column,
      plot,
      first,
      other,
      first,
      plot);
}

}  // namespace silvafit::stand
