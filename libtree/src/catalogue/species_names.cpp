// SPDX-License-Identifier: MIT
#include "catalogue/species_names.hpp"

#include <cctype>

namespace silvafit::tree {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::string genus_of(const std::string& species) { return species.substr(0, species.find(' ')); }

}  // namespace silvafit::tree
