// SPDX-License-Identifier: MIT
#include "mixed_effects/crossed_checks.hpp"

#include <fmt/format.h>

#include "silvafit/base/error.hpp"

namespace silvafit::fit {

void check_crossed_groups(const NonlinearModel& model) {
  if (model.crossed() == nullptr) return;
  for (std::size_t t = 0; t < model.term_count(); ++t) {
    const RandomEffects& term = model.specification().random[t];
    const Index groups = model.group_count(t);
    const Index effects = groups * std::ssize(term.coefficients);
    const std::string of = fmt::format("`{} | {}`", term.text(), term.group_text());
    const Place place{.file = model.place(0).file, .column = term.group};
    if (groups < 2) {
      throw InputError(
          fmt::format("{}: all {} rows are in the group '{}', so that the variance between groups "
                      "cannot be estimated; remove the term",
                      of,
                      model.observations(),
                      model.group_labels(t).front()),
          place);
    }
    if (effects >= model.observations()) {
      throw InputError(
          fmt::format("{}: {} groups have {} random effects, as many as the {} rows or more, so "
                      "that effects and residuals cannot be distinguished; remove effects, or use "
                      "coarser groups",
                      of,
                      groups,
                      effects,
                      model.observations()),
          place);
    }
  }
}

}  // namespace silvafit::fit
