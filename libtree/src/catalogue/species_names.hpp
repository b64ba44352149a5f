// SPDX-License-Identifier: MIT
// Finding the preset that lists a species.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace silvafit::tree {

/// Listed by the preset for species that no other preset lists.
inline constexpr std::string_view kAnySpecies = "*";

std::string lower_case(std::string_view text);
std::string genus_of(const std::string& species);

/// The first preset that lists a species by its full name or code, else by its genus, regardless of
/// case; the end if none does.
/// \param species_of  gives a preset's list of names
template <typename Presets, typename SpeciesOf>
auto find_species(std::string_view species, const Presets& presets, SpeciesOf species_of) {
  const auto listing = [&](const std::string& wanted) {
    return std::find_if(presets.begin(), presets.end(), [&](const auto& preset) {
      const auto& listed = species_of(preset);
      return !wanted.empty() && wanted != kAnySpecies &&
             std::any_of(listed.begin(), listed.end(), [&](const std::string& name) {
               return lower_case(name) == wanted;
             });
    });
  };
  const std::string wanted = lower_case(species);
  const auto exact = listing(wanted);
  return exact != presets.end() ? exact : listing(genus_of(wanted));
}

}  // namespace silvafit::tree
