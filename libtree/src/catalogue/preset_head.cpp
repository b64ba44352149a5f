// SPDX-License-Identifier: MIT
#include "catalogue/preset_head.hpp"

#include <cmath>
#include <utility>

#include "catalogue/leafy_shoots_entry.hpp"

namespace silvafit::tree {

data::JsonReader open_entry(const std::filesystem::path& file, std::string_view schema) {
  data::JsonReader entry = data::JsonReader::open(file);
  entry.at("schema").one_of({schema});
  return entry;
}

void read_head(const std::filesystem::path& models,
               const data::JsonReader& entry,
               PresetHead& head) {
  const data::JsonReader crown = entry.at("crown");
  head.name = entry.at("name").text();
  head.title = entry.at("title").text();
  head.species = entry.at("species").texts();
  head.crown_index = {crown.at("index_up").number_between(1.0, 3.0),
                      crown.at("index_down").number_between(1.0, 3.0)};
  head.relative_hc = crown.at("relative_hc").number_between(0.0, 1.0);
  head.taper = Taper::load(models / "taper" / (entry.at("taper").text() + ".json"));
  head.bark = bark_of(models, entry);
  // `basis` is required: it separates published from guessed numbers.
  for (const auto& [field, basis] : entry.at("basis").members()) basis.any_text();
}

void read_head(const std::filesystem::path& models,
               const data::JsonReader& entry,
               std::vector<std::string_view> others,
               PresetHead& head) {
  others.insert(others.end(),
                {"schema",
                 "name",
                 "title",
                 "species",
                 "taper",
                 "crown",
                 "leaves",
                 "bark_color",
                 "bark",
                 "bark_by_diameter",
                 "basis"});
  entry.allow_only(others);
  read_head(models, entry, head);
}

void read_head(const std::filesystem::path& models,
               const data::JsonReader& entry,
               std::vector<std::string_view> others,
               FreePreset& preset) {
  others.insert(others.end(), {"leafy_shoots"});
  read_head(models, entry, std::move(others), static_cast<PresetHead&>(preset));
  preset.style.bark = preset.bark;
  if (entry.has("leafy_shoots")) {
    preset.style.shoots = leafy_shoots_of(models, entry.at("leafy_shoots"));
  }
}

Color color_of(const data::JsonReader& entry) {
  const Color color = numbers_of<3>(entry);
  for (const double channel : color) {
    if (!(channel >= 0.0 && channel <= 1.0)) entry.fail("must be three numbers in [0, 1]");
  }
  return color;
}

int whole_number(const data::JsonReader& entry, int low, int high) {
  const double value = entry.number_between(low, high);
  const int number = static_cast<int>(value);
  if (number != value) entry.fail("must be an integer");
  return number;
}

void read_given_numbers(const data::JsonReader& entry,
                        const std::vector<PresetNumber>& numbers,
                        const std::vector<std::string_view>& others) {
  std::vector<std::string_view> keys = others;
  for (const PresetNumber& number : numbers) keys.push_back(number.key);
  entry.allow_only(keys);
  for (const auto& [key, into, low, high] : numbers) {
    if (!entry.has(key)) continue;
    if (const auto* whole = std::get_if<int*>(&into)) {
      **whole = whole_number(entry.at(key), static_cast<int>(low), static_cast<int>(high));
    } else {
      *std::get<double*>(into) = entry.at(key).number_between(low, high);
    }
  }
}

void read_numbers(const data::JsonReader& entry,
                  const std::vector<PresetNumber>& numbers,
                  const std::vector<std::string_view>& others) {
  read_given_numbers(entry, numbers, others);
  for (const PresetNumber& number : numbers) entry.at(number.key);
}

namespace {

std::vector<std::array<double, 2>> outline_of(const data::JsonReader& entry) {
  auto outline = rows_of<2>(entry);
  std::array<double, 2> before{1.0, -1.0};
  for (const auto& [across, along] : outline) {
    // Seen from the petiole, each point is to the left of the previous one, also with lobes.
    const bool is_left = along * before[0] > before[1] * across;
    if (!(across > 0.0 && across <= 1.0 && std::abs(along) < 1.0 && is_left)) {
      entry.fail(
          "must be [across, along] with across in (0, 1] and along in (-1, 1), in angular order "
          "around the end of the petiole, from the base to the tip");
    }
    before = {across, along};
  }
  constexpr std::size_t kLeast = 3;
  if (outline.size() < kLeast) {
    entry.fail("must have at least three points");
  }
  return outline;
}

}  // namespace

LeafLook leaf_look_of(const data::JsonReader& entry) {
  LeafLook look;
  read_numbers(
      entry,
      {{"aspect", &look.aspect, 0.05, 2.0}, {"color_variation", &look.color_variation, 0.0, 0.5}},
      {"form", "color", "outline"});
  look.form = entry.at("form").one_of({"five-polygons", "needle-fan"}) == 0
                  ? LeafForm::kFivePolygons
                  : LeafForm::kNeedleFan;
  look.color = color_of(entry.at("color"));
  if (entry.has("outline")) look.outline = outline_of(entry.at("outline"));
  return look;
}

}  // namespace silvafit::tree
