// SPDX-License-Identifier: MIT
#include "catalogue/leafy_shoots_entry.hpp"

#include <map>
#include <mutex>

#include "catalogue/preset_head.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"

namespace silvafit::tree {
namespace {

/// Pictures take a tenth of a second to draw: files with the same text share one while it is used.
template <typename Picture, typename Read>
std::shared_ptr<const Picture> shared_picture(const std::filesystem::path& file, Read read) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<const Picture>> known;
  const std::string text = read_file(file);
  const std::scoped_lock lock(mutex);
  std::shared_ptr<const Picture> picture = known[text].lock();
  if (picture == nullptr) {
    picture = std::make_shared<const Picture>(read(file));
    known[text] = picture;
  }
  return picture;
}

Tint tint_of(const data::JsonReader& entry) {
  const Tint tint = numbers_of<3>(entry);
  for (const double channel : tint) {
    if (!(channel >= 0.0 && channel <= 10.0)) entry.fail("must be three numbers in [0, 10]");
  }
  return tint;
}

ShootPlan shoot_plan_of(const std::filesystem::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-shoots/1");
  ShootPlan plan{.name = entry.at("name").text()};
  read_given_numbers(entry,
                     {{"seed", &plan.seed, 0, 1000},
                      {"rise", &plan.blade.rise, 0.05, 5.0},
                      {"fall", &plan.blade.fall, 0.05, 5.0},
                      {"veins", &plan.blade.veins, 0.0, 30.0},
                      {"leaf_length", &plan.leaf_length, 0.01, 0.9},
                      {"leaf_aspect", &plan.leaf_aspect, 0.01, 2.0},
                      {"spacing", &plan.spacing, 0.002, 1.0},
                      {"whorl", &plan.whorl, 0, 100},
                      {"angle_deg", &plan.angle_deg, 0.0, 150.0},
                      {"angle_sd_deg", &plan.angle_sd_deg, 0.0, 60.0},
                      {"bare", &plan.bare, 0.0, 0.95},
                      {"side_twigs", &plan.side_twigs, 0, 40},
                      {"side_length", &plan.side_length, 0.01, 1.0},
                      {"side_angle_deg", &plan.side_angle_deg, 0.0, 120.0},
                      {"droop", &plan.droop, 0.0, 3.0},
                      {"bend", &plan.bend, 0.0, 1.0},
                      {"twig_width", &plan.twig_width, 0.001, 0.1},
                      {"shade_sd", &plan.shade_sd, 0.0, 0.5},
                      {"warmth_sd", &plan.warmth_sd, 0.0, 1.0},
                      {"shadow", &plan.shadow, 0.0, 1.0}},
                     {"schema", "name", "shows", "opposite", "outline", "twig"});
  entry.at("shows").any_text();
  plan.is_opposite = entry.has("opposite") && entry.at("opposite").boolean();
  if (entry.has("outline")) plan.blade.outline = rows_of<2>(entry.at("outline"));
  if (entry.has("twig")) plan.twig = tint_of(entry.at("twig"));
  return plan;
}

BarkLayer bark_layer_of(const data::JsonReader& entry) {
  using Pattern = BarkLayer::Pattern;
  constexpr std::array kPatterns{Pattern::kNoise, Pattern::kRidges, Pattern::kDashes};
  BarkLayer layer{.pattern =
                      kPatterns.at(entry.at("pattern").one_of({"noise", "ridges", "dashes"}))};
  read_given_numbers(entry,
                     {{"across", &layer.across, 1, 64},
                      {"along", &layer.along, 1, 128},
                      {"octaves", &layer.octaves, 1, 5},
                      {"swerve", &layer.swerve, 0.0, 1.0},
                      {"from", &layer.from, 0.0, 1.0},
                      {"to", &layer.to, 0.0, 1.0},
                      {"height", &layer.height, -2.0, 2.0}},
                     {"pattern", "tint"});
  if (layer.from == layer.to) entry.at("to").fail("must differ from the field from");
  if (entry.has("tint")) layer.tint = tint_of(entry.at("tint"));
  return layer;
}

BarkPlan bark_plan_of(const std::filesystem::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-bark/1");
  BarkPlan plan{.name = entry.at("name").text()};
  read_numbers(entry,
               {{"width_m", &plan.width_m, 0.05, 5.0}, {"relief", &plan.relief, 0.0, 0.2}},
               {"schema", "name", "shows", "roots", "layers"});
  entry.at("shows").any_text();
  plan.has_roots = entry.at("roots").boolean();
  for (const data::JsonReader& layer : entry.at("layers").items()) {
    plan.layers.push_back(bark_layer_of(layer));
  }
  return plan;
}

/// The file that a field names.
std::filesystem::path file_of(const std::filesystem::path& folder, const data::JsonReader& entry) {
  std::filesystem::path file = folder / (entry.text() + ".json");
  if (kind_of(file) == PathKind::kFile) return file;
  std::string names;
  for (const auto& other : files_in_folder(folder, ".json")) {
    names += (names.empty() ? "" : ", ") + other.stem().string();
  }
  entry.fail("must be one of " + names);
}

}  // namespace

std::shared_ptr<const ShootPicture> shoot_picture(const std::filesystem::path& file) {
  return shared_picture<ShootPicture>(file, shoot_plan_of);
}

std::shared_ptr<const BarkPicture> bark_picture(const std::filesystem::path& file) {
  return shared_picture<BarkPicture>(file, bark_plan_of);
}

LeafyShoots leafy_shoots_of(const std::filesystem::path& models, const data::JsonReader& entry) {
  LeafyShoots shoots{.picture = shoot_picture(file_of(models / "shoots", entry.at("picture")))};
  read_numbers(
      entry,
      {{"length_m", &shoots.length_m, 0.05, 3.0},
       {"leaf_area_index", &shoots.leaf_area_index, 0.1, 20.0},
       {"angle_deg", &shoots.angle_deg, 0.0, 120.0},
       {"lift", &shoots.lift, -2.0, 2.0},
       {"cross_deg", &shoots.cross_deg, 10.0, 90.0}},
      {"picture", "reach", "groove", "whole_twigs", "deciduous", "autumn_color", "spring_color"});
  shoots.is_whole_twig = entry.has("whole_twigs") && entry.at("whole_twigs").boolean();
  if (entry.has("reach")) shoots.reach = entry.at("reach").number_between(0.0, 20.0);
  if (entry.has("groove")) shoots.groove = entry.at("groove").number_between(0.0, 1.0);
  shoots.is_deciduous = entry.has("deciduous") && entry.at("deciduous").boolean();
  if (entry.has("autumn_color")) shoots.autumn = color_of(entry.at("autumn_color"));
  if (entry.has("spring_color")) shoots.spring = color_of(entry.at("spring_color"));
  return shoots;
}

Bark bark_of(const std::filesystem::path& models, const data::JsonReader& entry) {
  Bark bark{.color = color_of(entry.at("bark_color"))};
  constexpr const char* kUsual = "smooth";
  bark.picture = entry.has("bark")
                     ? bark_picture(file_of(models / "bark", entry.at("bark")))
                     : bark_picture(models / "bark" / (std::string(kUsual) + ".json"));
  if (!entry.has("bark_by_diameter")) return bark;
  const data::JsonReader shades = entry.at("bark_by_diameter");
  for (const auto& [diameter, red, green, blue] : rows_of<4>(shades)) {
    const bool increases = bark.shades.empty() || diameter > bark.shades.back().relative_diameter;
    const bool is_color = std::ranges::all_of(
        Color{red, green, blue}, [](double value) { return value >= 0.0 && value <= 1.0; });
    if (!increases || !is_color || !(diameter >= 0.0)) {
      shades.fail(
          "must be [diameter, red, green, blue] with increasing diameters and colors in [0, 1]");
    }
    bark.shades.push_back({diameter, {red, green, blue}});
  }
  return bark;
}

}  // namespace silvafit::tree
