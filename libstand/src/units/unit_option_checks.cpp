// SPDX-License-Identifier: MIT
#include "units/unit_option_checks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "units/unit_indices.hpp"

namespace silvafit::stand {
namespace {

bool is_angle(double degrees) { return degrees > 0.0 && degrees <= 180.0; }

void check_angles(const Inventory& inventory, const StructuralUnitOptions& options) {
  const auto refuse = [](double degrees) {
    throw UsageError(fmt::format("{} degrees must be above 0 and at most 180", degrees),
                     {.column = "`alpha`"});
  };
  if (options.alpha0_deg && !is_angle(*options.alpha0_deg)) refuse(*options.alpha0_deg);
  for (const auto& [species, degrees] : options.alpha0_deg_of_species) {
    if (!is_angle(degrees)) refuse(degrees);
  }
  if (options.is_part) return;
  check_species_of_angles(options, inventory.species.levels(), inventory.file);
}

void check_measures(const Inventory& inventory, const StructuralUnitOptions& options) {
  if (sizes_of(inventory, options.size).empty()) {
    throw UsageError(fmt::format("no column '{0}', which is needed to compare trees by {0}",
                                 options.size == SizeMeasure::kHeight ? "h" : "cw"),
                     {.file = inventory.file, .column = "`dominance`"});
  }
  const bool has_radii = !inventory.cr_e_m.empty() && !inventory.cr_w_m.empty() &&
                         !inventory.cr_s_m.empty() && !inventory.cr_n_m.empty();
  if (options.reach == CrownReach::kFacingRadii && !has_radii) {
    throw UsageError("`crowding=facing` needs the columns cr_e, cr_w, cr_s and cr_n",
                     {.file = inventory.file, .column = "`crowding`"});
  }
}

}  // namespace

void check_unit_options(const Inventory& inventory, const StructuralUnitOptions& options) {
  if (options.neighbors < 1 || options.neighbors > kMostNeighbors) {
    throw UsageError(fmt::format("{} must be between 1 and {}", options.neighbors, kMostNeighbors),
                     {.column = "`neighbors`"});
  }
  check_angles(inventory, options);
  if (!(options.buffer_m >= 0.0) || std::isinf(options.buffer_m)) {
    throw UsageError(fmt::format("{} m must be 0 or more", options.buffer_m),
                     {.column = "`buffer`"});
  }
  if (!(options.competition_radius_m >= 0.0) || std::isinf(options.competition_radius_m)) {
    throw UsageError(fmt::format("{} m must be 0 or more", options.competition_radius_m),
                     {.column = "`competition_radius`"});
  }
  if (!inventory.has_coordinates()) {
    throw UsageError("structural units need the columns x and y", {.file = inventory.file});
  }
  check_measures(inventory, options);
}

void check_species_of_angles(const StructuralUnitOptions& options,
                             const std::vector<std::string>& species,
                             const std::string& file) {
  for (const auto& [name, degrees] : options.alpha0_deg_of_species) {
    if (std::ranges::find(species, name) != species.end()) continue;
    throw UsageError(
        fmt::format("unknown species '{}'; available: {}", name, fmt::join(species, ", ")),
        {.file = file, .column = "`alpha`"});
  }
}

}  // namespace silvafit::stand
