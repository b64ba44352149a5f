// SPDX-License-Identifier: MIT
#include "silvafit/tree/species_map.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "catalogue/preset_head.hpp"
#include "silvafit/base/folded_text.hpp"

namespace silvafit::tree {
namespace {

std::vector<std::string> split_names(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream words(text);
  for (std::string name; std::getline(words >> std::ws, name, ';');) names.push_back(name);
  return names;
}

/// In lower case and without accents, with blanks for underscores; a code as a whole number without
/// leading zeros.
std::string plain_name(std::string_view name) {
  std::string plain = folded(name);
  std::ranges::replace(plain, '_', ' ');
  std::string_view digits = plain;
  if (digits.ends_with(".0")) digits.remove_suffix(2);
  const bool is_code =
      !digits.empty() && digits.find_first_not_of("0123456789") == std::string::npos;
  if (!is_code) return plain;
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return std::string(digits);
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::string genus_of(const std::string& species) { return species.substr(0, species.find(' ')); }

SpeciesMap SpeciesMap::load(const std::filesystem::path& models) {
  const data::JsonReader entry = open_entry(models / "species.json", "silvafit-species/1");
  SpeciesMap map;
  for (const data::JsonReader& row : entry.at("species").items()) {
    std::vector<std::string> cells;
    for (const data::JsonReader& cell : row.items()) cells.push_back(cell.any_text());
    constexpr std::size_t kColumns = 4;
    if (cells.size() != kColumns) row.fail("must be [Latin name, common names, code, preset]");
    const Species species{cells[0], split_names(cells[1]), cells[2], cells[3]};
    std::vector<std::string> names = species.common;
    names.push_back(species.latin);
    if (!species.fia.empty()) names.push_back(species.fia);
    for (const std::string& name : names) {
      // Spellings of one species, bjørk and björk, may be the same.
      const std::size_t own = map.species_.size();
      const bool is_own = map.by_name_.emplace(folded(name), own).first->second == own;
      if (!is_own) row.fail("has a name that another row has: " + name);
    }
    map.species_.push_back(species);
  }
  return map;
}

const SpeciesMap::Species* SpeciesMap::listed(const std::string& lower) const {
  const auto found = by_name_.find(lower);
  return found == by_name_.end() ? nullptr : &species_[found->second];
}

/// The only species with this initial of the genus and this epithet, of "p. abies".
const SpeciesMap::Species* SpeciesMap::abbreviated(const std::string& lower) const {
  if (lower.size() < 4 || lower.substr(1, 2) != ". ") return nullptr;
  const std::string epithet = lower.substr(2, lower.find(' ', 3) - 2);
  const Species* found = nullptr;
  for (const Species& species : species_) {
    const std::string latin = lower_case(species.latin);
    if (latin.front() != lower.front() || !latin.ends_with(epithet)) continue;
    if (found != nullptr) return nullptr;
    found = &species;
  }
  return found;
}

const SpeciesMap::Species* SpeciesMap::find(std::string_view name) const {
  const std::string lower = plain_name(name);
  const Species* species = listed(lower);
  if (species == nullptr) species = abbreviated(lower);
  // Varieties and authors follow the two words of a species.
  const std::size_t genus = lower.find(' ');
  if (species == nullptr && genus != std::string::npos) {
    species = listed(lower.substr(0, lower.find(' ', genus + 1)));
  }
  return species != nullptr ? species : listed(genus_of(lower));
}

}  // namespace silvafit::tree
