// SPDX-License-Identifier: MIT
#include "catalogue/preset_head.hpp"

#include <map>

namespace silvafit::tree {

PresetHead preset_head_of(const std::filesystem::path& models, const JsonEntry& entry) {
  const JsonEntry crown = entry.child("crown");
  PresetHead head;
  head.name = entry.get<std::string>("name");
  head.title = entry.get<std::string>("title");
  head.species = entry.get<std::vector<std::string>>("species");
  head.crown_index = {crown.number("index_up", 1.0, 2.0), crown.number("index_down", 1.0, 2.0)};
  head.relative_hc = crown.number("relative_hc", 0.0, 1.0);
  head.taper = Taper::load(models / "taper" / (entry.get<std::string>("taper") + ".json"));
  // `basis` is required: it separates published from guessed numbers.
  entry.get<std::map<std::string, std::string>>("basis");
  return head;
}

double largest_gap_of(const JsonEntry& entry) {
  constexpr double kSmallest = 0.1;
  return entry.has("largest_gap") ? entry.number("largest_gap", kSmallest, 2.0) : 0.0;
}

Color color_of(const JsonEntry& entry, const std::string& field) {
  const auto color = entry.get<Color>(field);
  for (const double channel : color) {
    if (!(channel >= 0.0 && channel <= 1.0)) {
      throw InputError("must be three numbers in [0, 1]", entry.place_of(field));
    }
  }
  return color;
}

int whole_number(const JsonEntry& entry, const std::string& field, int low, int high) {
  const double value = entry.number(field, low, high);
  const int number = static_cast<int>(value);
  if (number != value) throw InputError("must be an integer", entry.place_of(field));
  return number;
}

}  // namespace silvafit::tree
