// SPDX-License-Identifier: MIT
// Species and their presets, and presets in all seasons.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

PresetChoice chosen(std::string_view species) {
  return test::shipped_builders().choose(BuilderKind::kSegment, species);
}

std::string preset_of(std::string_view species) { return chosen(species).builder->name(); }

Morphology usual_tree(const Builder& builder) {
  Morphology tree = test::paper_tree_1();
  tree.species = builder.name();
  return tree;
}

}  // namespace

// Codes of the table REF_SPECIES of the FIA database.
TEST_CASE("species are found by Latin name, common name, code and genus") {
  CHECK(preset_of("Pinus sylvestris") == "pinus-sylvestris");
  CHECK(preset_of("pinus SYLVESTRIS") == "pinus-sylvestris");
  CHECK(preset_of("Scots pine") == "pinus-sylvestris");
  CHECK(preset_of("Pinus sylvestris var. mongolica") == "pinus-sylvestris");
  CHECK(preset_of("131") == "pinus-taeda");
  CHECK(preset_of("202") == "pseudotsuga");
  CHECK(preset_of("316") == "acer");
  CHECK(preset_of("531") == "fagus");
  CHECK(preset_of("802") == "quercus-robur");
  CHECK(preset_of("Quercus virginiana") == "schima-superba");  // evergreen
  CHECK(preset_of("Betula ermanii") == "betula");
  CHECK(preset_of("Picea") == "picea-abies");
  CHECK(preset_of("Chinese fir") == "cunninghamia-lanceolata");
  CHECK(preset_of("SM") == "cunninghamia-lanceolata");
  CHECK(preset_of("Machilus thunbergii") == "machilus-pauhoi");
  CHECK(preset_of("Phyllostachys edulis") == "moso");
  CHECK(preset_of("Cocos nucifera") == "palm");
  CHECK(preset_of("Ficus microcarpa") == "banyan");
  CHECK(preset_of("Cyathea spinulosa") == "fern");
}

TEST_CASE(
    "names of species may be abbreviated, have underscores or zeros, or be those of a group") {
  CHECK(preset_of("Picea_abies") == "picea-abies");
  CHECK(preset_of("P. abies") == "picea-abies");
  CHECK(preset_of("p. sylvestris var. mongolica") == "pinus-sylvestris");
  CHECK(preset_of("P. alba") == "populus");
  CHECK(preset_of("A. alba") == "abies");
  // Pinus and Populus have a nigra each.
  CHECK_FALSE(chosen("P. nigra").is_listed);
  CHECK(preset_of("0131") == "pinus-taeda");
  CHECK(chosen("0131").code_of == "Pinus taeda");
  CHECK_FALSE(chosen("0").is_listed);
  CHECK(preset_of("Fichte") == "picea-abies");
  CHECK(preset_of("hêtre") == "fagus");
  CHECK(preset_of("other conifer") == "generic-conifer");
  CHECK(preset_of("Laubholz") == "generic-broadleaf");
}

TEST_CASE("a species that no preset lists has the usual preset, and codes are told") {
  CHECK_FALSE(chosen("OF").is_listed);
  CHECK_FALSE(chosen("").is_listed);
  CHECK_FALSE(chosen("*").is_listed);
  CHECK(preset_of("OF") == "generic-broadleaf");
  CHECK(chosen("131").code_of == "Pinus taeda");
  CHECK(chosen("Pinus taeda").code_of.empty());
  SpeciesNotes notes;
  for (const char* species : {"OF", "", "131", "Picea abies"}) notes.add(species, chosen(species));
  const std::vector<std::string> texts = notes.texts();
  REQUIRE(texts.size() == 3);
  CHECK(texts[0].find("without a species") != std::string::npos);
  CHECK(texts[1].find("\"OF\"; preset generic-broadleaf") != std::string::npos);
  CHECK(texts[2].find("131 Pinus taeda") != std::string::npos);
}

TEST_CASE("each species of the map has a preset, whatever name is used") {
  const SpeciesMap& map = test::shipped_builders().species();
  CHECK(map.all().size() >= 400);
  CHECK(std::ranges::count_if(map.all(), [](const auto& one) { return !one.fia.empty(); }) >= 300);
  for (const SpeciesMap::Species& species : map.all()) {
    INFO(species.latin);
    CHECK(map.find(species.latin) == &species);
    for (const std::string& name : species.common) CHECK(map.find(name) == &species);
    if (!species.fia.empty()) CHECK(map.find(species.fia) == &species);
    const PresetChoice choice = chosen(species.latin);
    CHECK(choice.is_listed);
    CHECK(choice.builder->name() == species.preset);
  }
}

TEST_CASE("names are found without regard to capitals, accents and the type of a code") {
  const SpeciesMap& map = test::shipped_builders().species();
  for (const char* const spruce : {"Épicéa", "EPICEA", "épicéa commun", "abeto rojo", "云杉"}) {
    INFO(spruce);
    REQUIRE(map.find(spruce) != nullptr);
    CHECK(map.find(spruce)->preset == "picea-abies");
  }
  REQUIRE(map.find("131.0") != nullptr);
  CHECK(map.find("131.0")->latin == "Pinus taeda");
  CHECK(map.find("0.0") == nullptr);
  REQUIRE(map.find("CHÊNE VERT") != nullptr);
  CHECK(map.find("CHÊNE VERT")->latin == "Quercus ilex");
}

TEST_CASE("the season changes leaves only, and no measurement") {
  std::set<std::string> bare;
  for (const BuilderKind kind : all_values<BuilderKind>()) {
    for (const Builder* builder : test::shipped_builders().of(kind)) {
      const Morphology tree = usual_tree(*builder);
      for (const bool textured : {false, true}) {
        const auto grown = [&](Season season) {
          return grow_tree(tree, *builder, {.mesh = {.textured = textured, .season = season}});
        };
        const auto foliage_of = [](const SceneTree& one) {
          const auto part = std::ranges::find(one.mesh.parts, PartKind::kFoliage, &MeshPart::kind);
          return part == one.mesh.parts.end() ? nullptr : &*part;
        };
        const SceneTree summer = grown(Season::kSummer);
        for (const Season season : {Season::kAutumn, Season::kWinter, Season::kSpring}) {
          const SceneTree other = grown(season);
          INFO(builder->name() << ' ' << textured << ' ' << static_cast<int>(season));
          CHECK(other.measured.h_m == summer.measured.h_m);
          CHECK(other.measured.hcb_m == summer.measured.hcb_m);
          CHECK(other.measured.dbh_cm == summer.measured.dbh_cm);
          const CrownRadii& a = other.measured.radii;
          const CrownRadii& b = summer.measured.radii;
          // The same as without leaves to the millimeter that floats and rings have.
          CHECK(a.east_m == Approx(b.east_m).margin(0.002));
          CHECK(a.west_m == Approx(b.west_m).margin(0.002));
          CHECK(a.south_m == Approx(b.south_m).margin(0.002));
          CHECK(a.north_m == Approx(b.north_m).margin(0.002));
        }
        const SceneTree winter = grown(Season::kWinter);
        const MeshPart* const leaves = foliage_of(winter);
        const bool is_bare = leaves == nullptr || (leaves->texture != nullptr &&
                                                   leaves->texture->name.starts_with("twigs-"));
        if (is_bare && foliage_of(summer) != nullptr) bare.insert(builder->name());
      }
    }
  }
  for (const char* name : {"larix",
                           "quercus-robur",
                           "fagus",
                           "betula",
                           "populus",
                           "acer",
                           "fraxinus",
                           "generic-broadleaf",
                           "maple"}) {
    INFO(name);
    CHECK(bare.contains(name));
  }
  for (const char* name : {"pinus-sylvestris",
                           "picea-abies",
                           "abies",
                           "pseudotsuga",
                           "cunninghamia-lanceolata",
                           "eucalyptus",
                           "schima-superba",
                           "palm",
                           "banyan",
                           "moso"}) {
    INFO(name);
    CHECK_FALSE(bare.contains(name));
  }
}
