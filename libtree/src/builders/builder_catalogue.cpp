// SPDX-License-Identifier: MIT
#include <algorithm>

#include "catalogue/species_names.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/tree/bamboo.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/ifs.hpp"
#include "silvafit/tree/lsystem_builder.hpp"

namespace silvafit::tree {

namespace {

/// The .json files of a folder; none if there is no such folder.
std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder) {
  if (kind_of(folder) != PathKind::kFolder) return {};
  return files_in_folder(folder, ".json");
}

}  // namespace

BuilderCatalogue BuilderCatalogue::load(const std::filesystem::path& models) {
  BuilderCatalogue catalogue;
  catalogue.segment_presets_ =
      std::make_unique<const PresetCatalogue>(PresetCatalogue::load(models));
  for (const Preset& preset : catalogue.segment_presets_->presets()) {
    catalogue.builders_.push_back(std::make_unique<const SegmentBuilder>(preset));
  }
  for (const auto& file : entries_of(models / "lsystems")) {
    catalogue.builders_.push_back(LsystemBuilder::load(models, file));
  }
  for (const auto& file : entries_of(models / "ifs")) {
    catalogue.builders_.push_back(IfsBuilder::load(models, file));
  }
  for (const auto& file : entries_of(models / "bamboo")) {
    catalogue.builders_.push_back(
        std::make_unique<const BambooBuilder>(BambooPreset::load(models, file)));
  }
  std::sort(catalogue.builders_.begin(),
            catalogue.builders_.end(),
            [](const auto& a, const auto& b) { return a->name() < b->name(); });
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
  for (const Builder* builder : of(kind)) {
    if (builder->name() == name) return *builder;
    names += (names.empty() ? "" : ", ") + builder->name();
  }
  throw UsageError("unknown preset '" + std::string(name) + "' of builder " + builder_name(kind) +
                   "; available: " + names);
}

const Builder* BuilderCatalogue::for_species(BuilderKind kind, std::string_view species) const {
  const std::vector<const Builder*> builders = of(kind);
  const auto found = find_species(
      species, builders, [](const Builder* builder) { return builder->preset().species; });
  return found == builders.end() ? nullptr : *found;
}

const Builder& BuilderCatalogue::fallback(BuilderKind kind) const {
  for (const Builder* builder : of(kind)) {
    const std::vector<std::string>& species = builder->preset().species;
    if (std::find(species.begin(), species.end(), kAnySpecies) != species.end()) return *builder;
  }
  throw InputError(std::string("no preset of builder ") + builder_name(kind) +
                   " has \"*\" among its species (for species that no other preset lists)");
}

}  // namespace silvafit::tree
