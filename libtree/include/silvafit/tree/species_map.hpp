// SPDX-License-Identifier: MIT
// Species and the presets that draw them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace silvafit::tree {

std::string lower_case(std::string_view text);
std::string genus_of(const std::string& species);

/// The species and genera of models/species.json.
class SpeciesMap {
 public:
  struct Species {
    std::string latin{};
    std::vector<std::string> common{};
    std::string fia{};  ///< code of the Forest Inventory and Analysis program, or empty
    std::string preset{};
  };

  /// \throws InputError naming the file and the row if a name occurs twice
  static SpeciesMap load(const std::filesystem::path& models);

  const std::vector<Species>& all() const { return species_; }

  /// By Latin name, common name or code, else by the first two words or the genus, regardless of
  /// case; null if there is none.
  const Species* find(std::string_view name) const;

 private:
  const Species* listed(const std::string& lower) const;
  const Species* abbreviated(const std::string& lower) const;

  std::vector<Species> species_{};
  std::unordered_map<std::string, std::size_t> by_name_{};  ///< in lower case
};

}  // namespace silvafit::tree
