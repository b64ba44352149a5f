// SPDX-License-Identifier: MIT
#include "morphology/plot_choice.hpp"

#include <algorithm>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

/// A name for a list, in double quotes if it contains a comma.
std::string in_list(const std::string& name) {
  return name.find(',') == std::string::npos ? name : '"' + name + '"';
}

/// "01, 02, 03", or the first of many and the number of the others.
std::string some_of(const std::vector<std::string>& plots) {
  constexpr std::size_t kShown = 10;
  std::string list;
  for (std::size_t i = 0; i < std::min(kShown, plots.size()); ++i) {
    list += (i > 0 ? ", " : "") + in_list(plots[i]);
  }
  if (plots.size() > kShown) list += " and " + std::to_string(plots.size() - kShown) + " more";
  return list;
}

}  // namespace

void require_plots(const std::vector<std::string>& chosen,
                   const data::TextColumn& labels,
                   const std::string& file) {
  for (const std::string& plot : chosen) {
    if (labels.code_of(plot) != data::TextColumn::kMissingCode) continue;
    const std::vector<std::string>& plots = labels.levels();
    std::string message = "no trees in plot " + plot;
    if (!plots.empty()) {
      message += (plots.size() == 1 ? "; the only plot is " : "; available: ") + some_of(plots);
    }
    throw InputError(message, {.file = file});
  }
}

}  // namespace silvafit::tree
