// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>

#include "bamboo/bamboo.hpp"
#include "iterated_functions/ifs.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/lsystem_builder.hpp"

namespace silvafit::tree {

namespace {

/// Listed by the preset for species that no other preset lists.
constexpr std::string_view kAnySpecies = "*";

/// The first preset that lists a species by its full name or code, else by its genus, regardless of
/// case; null if none does.
const Builder* listing(std::string_view species, const std::vector<const Builder*>& builders) {
  const std::string name = lower_case(species);
  for (const std::string& wanted : {name, genus_of(name)}) {
    if (wanted.empty() || wanted == kAnySpecies) continue;
    for (const Builder* builder : builders) {
      const bool is_listed = std::ranges::any_of(
          builder->preset().species,
          [&wanted](const std::string& listed) { return lower_case(listed) == wanted; });
      if (is_listed) return builder;
    }
  }
  return nullptr;
}

template <typename Load>
void load_all(const std::filesystem::path& models,
              const char* folder,
              Load load,
              std::vector<std::unique_ptr<const Builder>>& builders) {
  if (kind_of(models / folder) != PathKind::kFolder) return;
  for (const auto& file : files_in_folder(models / folder, ".json")) {
    builders.push_back(load(models, file));
  }
}

}  // namespace

BuilderCatalogue BuilderCatalogue::load(const std::filesystem::path& models) {
  BuilderCatalogue catalogue;
  auto& builders = catalogue.builders_;
  load_all(models, "presets", SegmentBuilder::load, builders);
  if (builders.empty()) {
    throw InputError("no species presets in this folder", {.file = (models / "presets").string()});
  }
  load_all(models, "lsystems", LsystemBuilder::load, builders);
  load_all(models, "ifs", IfsBuilder::load, builders);
  load_all(models, "bamboo", BambooBuilder::load, builders);
  std::ranges::sort(builders, {}, [](const auto& builder) { return builder->name(); });
  catalogue.species_ = SpeciesMap::load(models);
  for (const SpeciesMap::Species& species : catalogue.species_.all()) {
    catalogue.named(BuilderKind::kSegment, species.preset);
  }
  return catalogue;
}

std::vector<const Builder*> BuilderCatalogue::of(BuilderKind kind) const {
  std::vector<const Builder*> builders;
  for (const auto& builder : builders_) {
    if (builder->kind() == kind) builders.push_back(builder.get());
  }
  return builders;
}

const Builder& BuilderCatalogue::named(BuilderKind kind, std::string_view name) const {
  std::string names;
  for (const auto& builder : builders_) {
    if (kind != BuilderKind::kSegment && builder->kind() != kind) continue;
    if (builder->name() == name) return *builder;
    names += (names.empty() ? "" : ", ") + builder->name();
  }
  throw UsageError("unknown preset '" + std::string(name) + "' of builder " + word_of(kind) +
                   "; available: " + names);
}

PresetChoice BuilderCatalogue::choose(BuilderKind kind,
                                      std::string_view species,
                                      bool reads_codes) const {
  const bool is_code = species.find_first_not_of("0123456789") == std::string_view::npos;
  if (is_code && !reads_codes) return {.builder = &fallback(kind), .is_listed = false};
  const SpeciesMap::Species* const known = species_.find(species);
  PresetChoice choice;
  if (known != nullptr && is_code) choice.code_of = known->latin;
  const std::string_view latin = known != nullptr ? std::string_view(known->latin) : species;
  choice.builder = listing(latin, of(kind));
  if (choice.builder != nullptr) return choice;
  if (known != nullptr && kind == BuilderKind::kSegment) {
    choice.builder = &named(kind, known->preset);
  } else {
    choice.builder = &fallback(kind);
    choice.is_listed = false;
  }
  return choice;
}

std::vector<std::string> BuilderCatalogue::species_of(const Builder& builder) const {
  std::vector<std::string> names = builder.preset().species;
  for (const SpeciesMap::Species& species : species_.all()) {
    const SpeciesMap::Species* const genus = species_.find(genus_of(species.latin));
    const bool is_told = genus != &species && genus != nullptr && genus->preset == species.preset;
    if (species.preset != builder.name() || is_told) continue;
    if (std::ranges::find(names, species.latin) == names.end()) names.push_back(species.latin);
  }
  return names;
}

void SpeciesNotes::add(const std::string& species, const PresetChoice& choice) {
  if (!choice.is_listed) unlisted_[choice.builder->name()].insert(species);
  if (!choice.code_of.empty()) codes_[species] = choice.code_of;
}

std::vector<std::string> SpeciesNotes::texts() const {
  std::vector<std::string> notes;
  for (const auto& [preset, species] : unlisted_) {
    std::string names;
    for (const std::string& name : species) {
      if (!name.empty()) names += (names.empty() ? "\"" : ", \"") + name + '"';
    }
    if (species.contains("")) {
      notes.push_back(fmt::format("Trees without a species are drawn with preset {}.", preset));
    }
    if (names.empty()) continue;
    notes.push_back(fmt::format(
        "No preset lists the species {}; preset {} is used (see `preset`).", names, preset));
  }
  if (codes_.empty()) return notes;
  std::string codes;
  for (const auto& [code, latin] : codes_) {
    codes += fmt::format("{}{} {}", codes.empty() ? "" : ", ", code, latin);
  }
  notes.push_back(fmt::format("Codes of species are read as those of the FIA: {}.", codes));
  return notes;
}

const Builder& BuilderCatalogue::fallback(BuilderKind kind) const {
  for (const Builder* builder : of(kind)) {
    const std::vector<std::string>& species = builder->preset().species;
    if (std::find(species.begin(), species.end(), kAnySpecies) != species.end()) return *builder;
  }
  throw InputError("no preset of builder " + word_of(kind) +
                   " has \"*\" among its species (for species that no other preset lists)");
}

}  // namespace silvafit::tree
