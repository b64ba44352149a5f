// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "silvafit/stand/structural_units.hpp"

namespace silvafit::stand {
namespace {

constexpr std::array kAllFurther{FurtherIndex::kCrownOverlap,
                                 FurtherIndex::kDifferentiation,
                                 FurtherIndex::kHegyi,
                                 FurtherIndex::kBasalAreaLarger,
                                 FurtherIndex::kCrownCompetition};

}  // namespace

std::string_view name_of(FurtherIndex index) {
  constexpr std::array<std::string_view, kAllFurther.size()> kNames{
      "CO", "T", "Hegyi", "BAL", "CCF"};
  return kNames[static_cast<std::size_t>(index)];
}

std::optional<FurtherIndex> further_index_named(std::string_view name) {
  const auto found = std::ranges::find(kAllFurther, name, &name_of);
  return found == kAllFurther.end() ? std::nullopt : std::optional(*found);
}

std::span<const FurtherIndex> all_further_indices() { return kAllFurther; }

}  // namespace silvafit::stand
