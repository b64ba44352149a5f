// SPDX-License-Identifier: MIT
#include "silvafit/tree/preset.hpp"

#include <algorithm>

#include "catalogue/json_entry.hpp"
#include "catalogue/leafy_shoots_entry.hpp"
#include "catalogue/preset_head.hpp"
#include "catalogue/species_names.hpp"
#include "silvafit/base/paths.hpp"

namespace silvafit::tree {
namespace {

namespace fs = std::filesystem;

std::vector<AngleLayer> layers_of(const JsonEntry& entry) {
  std::vector<AngleLayer> layers;
  for (const auto& values : entry.get<std::vector<std::array<double, 3>>>("angle_layers")) {
    const auto [from, low, high] = values;
    const bool ascends = layers.empty() ? from == 0.0 : from > layers.back().from && from < 1.0;
    if (!ascends || !(low > 0.0 && low < high && high <= 90.0)) {
      throw InputError(
          "must be [from, low, high] with increasing 'from', starting at 0, and angles in (0, 90]",
          entry.place_of("angle_layers"));
    }
    layers.push_back({from, low, high});
  }
  if (layers.empty())
    throw InputError("must have at least one layer", entry.place_of("angle_layers"));
  return layers;
}

YearlyWhorls yearly_whorls_of(const JsonEntry& entry) {
  YearlyWhorls yearly;
  yearly.low = whole_number(entry, "low", 1, 20);
  yearly.high = whole_number(entry, "high", yearly.low, 20);
  yearly.spacing_m = entry.number("spacing_m", 0.001, 1.0);
  return yearly;
}

Fork fork_of(const JsonEntry& entry) {
  Fork fork;
  fork.limbs = whole_number(entry, "limbs", 1, 6);
  fork.from = entry.number("from", 0.0, 0.9);
  fork.to = entry.number("to", fork.from, 0.95);
  fork.low_deg = entry.number("low_deg", 1.0, 89.0);
  fork.high_deg = entry.number("high_deg", fork.low_deg, 90.0);
  fork.thickness = entry.number("thickness", 0.1, 1.0);
  return fork;
}

Branching branching_of(const JsonEntry& entry) {
  Branching branching;
  const auto arrangement = entry.get<std::string>("arrangement");
  if (arrangement != "whorls" && arrangement != "spiral") {
    throw InputError("must be whorls or spiral", entry.place_of("arrangement"));
  }
  if (arrangement == "whorls") {
    branching.arrangement = Arrangement::kWhorls;
    branching.per_whorl = whole_number(entry, "per_whorl", 1, 12);
    if (entry.has("whorl_spread")) branching.whorl_spread = entry.number("whorl_spread", 0.0, 1.0);
  } else {
    branching.arrangement = Arrangement::kSpiral;
    branching.per_whorl = 1;
    branching.divergence_deg = entry.number("divergence_deg", 0.0, 360.0);
  }
  branching.spacing_m = entry.number("spacing_m", 0.01, 10.0);
  branching.tip_density = entry.number("tip_density", 1.0, 3.0);
  branching.least = whole_number(entry, "least", 1, 1000);
  branching.most = whole_number(entry, "most", branching.least, 1000);
  branching.azimuth_sd_deg = entry.number("azimuth_sd_deg", 0.0, 90.0);
  branching.sag = entry.number("sag", -0.5, 0.5);
  branching.crookedness = entry.number("crookedness", 0.0, 0.3);
  branching.thickness = entry.number("thickness", 0.001, 0.4);
  branching.thickest = entry.number("thickest", 0.01, 1.0);
  branching.stem_bend = entry.number("stem_bend", 0.0, 0.5);
  branching.segments = whole_number(entry, "segments", 1, 12);
  branching.layers = layers_of(entry);
  if (entry.has("yearly_whorls")) branching.yearly = yearly_whorls_of(entry.child("yearly_whorls"));
  if (entry.has("fork")) branching.fork = fork_of(entry.child("fork"));
  return branching;
}

Twigs twigs_of(const JsonEntry& entry) {
  Twigs twigs;
  const auto arrangement = entry.get<std::string>("arrangement");
  if (arrangement != "pairs" && arrangement != "spiral") {
    throw InputError("must be pairs or spiral", entry.place_of("arrangement"));
  }
  twigs.arrangement = arrangement == "pairs" ? TwigArrangement::kPairs : TwigArrangement::kSpiral;
  twigs.spacing_m = entry.number("spacing_m", 0.01, 10.0);
  twigs.least = whole_number(entry, "least", 0, 100);
  twigs.most = whole_number(entry, "most", twigs.least, 100);
  twigs.angle_low_deg = entry.number("angle_low_deg", 1.0, 120.0);
  twigs.angle_high_deg = entry.number("angle_high_deg", twigs.angle_low_deg + 1.0, 130.0);
  twigs.from = entry.number("from", 0.0, 0.95);
  twigs.relative_length = entry.number("relative_length", 0.01, 1.5);
  twigs.tip_length = entry.number("tip_length", 0.01, 1.0);
  twigs.spread_deg = entry.number("spread_deg", 0.0, 90.0);
  twigs.lift = entry.number("lift", -1.0, 2.0);
  twigs.has_wood = entry.get<bool>("has_wood");
  twigs.segments = whole_number(entry, "segments", 1, 12);
  return twigs;
}

Foliage foliage_of(const JsonEntry& entry) {
  Foliage foliage;
  const auto kind = entry.get<std::string>("kind");
  if (kind != "needles" && kind != "leaves") {
    throw InputError("must be needles or leaves", entry.place_of("kind"));
  }
  if (kind == "needles") {
    foliage.kind = FoliageKind::kNeedles;
    foliage.fullness = entry.number("fullness", 0.05, 1.0);
    foliage.lift = entry.number("lift", 0.0, 2.0);
    foliage.droop = entry.number("droop", 0.0, 2.0);
  } else {
    foliage.kind = FoliageKind::kLeaves;
    foliage.tufts_per_shoot = whole_number(entry, "tufts_per_shoot", 0, 20);
    foliage.leaves_per_tuft = whole_number(entry, "leaves_per_tuft", 2, 60);
    foliage.leaf_length_m = entry.number("leaf_length_m", 0.01, 2.0);
    foliage.leaf_aspect = entry.number("leaf_aspect", 0.05, 2.0);
    foliage.tuft = Tuft::of(foliage.leaves_per_tuft, foliage.leaf_aspect);
  }
  foliage.inner = color_of(entry, "inner_color");
  foliage.outer = color_of(entry, "outer_color");
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(foliage.outer[i] > 0.0 && foliage.inner[i] <= foliage.outer[i])) {
      throw InputError("must be above 0 and not darker than inner_color",
                       entry.place_of("outer_color"));
    }
  }
  foliage.color_variation = entry.number("color_variation", 0.0, 0.5);
  return foliage;
}

Preset preset_of(const fs::path& models, const fs::path& file) {
  const JsonEntry entry = JsonEntry::load(file, "silvafit-preset/1");
  const PresetHead head = preset_head_of(models, entry);
  Preset preset;
  preset.name = head.name;
  preset.title = head.title;
  preset.species = head.species;
  preset.crown_index = head.crown_index;
  preset.relative_hc = head.relative_hc;
  preset.taper = head.taper;
  preset.branching = branching_of(entry.child("branching"));
  preset.twigs = twigs_of(entry.child("twigs"));
  if (entry.has("shoots")) preset.shoots = twigs_of(entry.child("shoots"));
  preset.foliage = foliage_of(entry.child("foliage"));
  preset.leafy_shoots = leafy_shoots_of(entry.child("leafy_shoots"));
  preset.bark = color_of(entry, "bark_color");
  preset.bark_kind = bark_kind_of(entry);
  if (entry.has("branch_count")) {
    preset.branch_count = BranchCount::load(models / "branch_count" /
                                            (entry.get<std::string>("branch_count") + ".json"));
  }
  return preset;
}

}  // namespace

PresetCatalogue PresetCatalogue::load(const fs::path& models) {
  const fs::path folder = models / "presets";
  if (kind_of(folder) != PathKind::kFolder) {
    throw InputError("no species presets in this folder", {.file = folder.string()});
  }
  PresetCatalogue catalogue;
  for (const auto& file : files_in_folder(folder, ".json")) {
    catalogue.presets_.push_back(preset_of(models, file));
  }
  std::sort(catalogue.presets_.begin(),
            catalogue.presets_.end(),
            [](const Preset& a, const Preset& b) { return a.name < b.name; });
  catalogue.fallback();
  return catalogue;
}

const Preset& PresetCatalogue::named(std::string_view name) const {
  std::string names;
  for (const Preset& preset : presets_) {
    if (preset.name == name) return preset;
    names += (names.empty() ? "" : ", ") + preset.name;
  }
  throw UsageError("unknown preset '" + std::string(name) + "'; available: " + names);
}

const Preset* PresetCatalogue::for_species(std::string_view species) const {
  const auto found = find_species(
      species, presets_, [](const Preset& preset) -> const auto& { return preset.species; });
  return found == presets_.end() ? nullptr : &*found;
}

}  // namespace silvafit::tree
