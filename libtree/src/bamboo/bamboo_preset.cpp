// SPDX-License-Identifier: MIT
#include <bit>
#include <cmath>

#include "bamboo/bamboo.hpp"
#include "bamboo/bamboo_leaves.hpp"
#include "catalogue/preset_head.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

CulmStyle culm_of(const data::JsonReader& entry) {
  CulmStyle culm;
  read_numbers(entry,
               {{"bend_deg", &culm.bend_deg, 0.0, 60.0},
                {"bend_sd_deg", &culm.bend_sd_deg, 0.0, 30.0},
                {"sun_azimuth_deg", &culm.sun_azimuth_deg, 0.0, 360.0},
                {"sun_azimuth_sd_deg", &culm.sun_azimuth_sd_deg, 0.0, 360.0},
                {"nod", &culm.nod, 0.0, 0.2},
                {"internode_m", &culm.internode_m, 0.01, 2.0},
                {"internodes_sd", &culm.internodes_sd, 0.0, 0.3},
                {"internode_base", &culm.internode_base, 0.01, 1.0},
                {"internode_top", &culm.internode_top, 0.01, 1.0},
                {"longest_at", &culm.longest_at, 0.05, 0.95},
                {"internode_length_sd", &culm.internode_length_sd, 0.0, 0.3},
                {"ridge_height", &culm.ridge_height, 0.0, 0.5},
                {"ridge_m", &culm.ridge_m, 0.001, 0.2},
                {"internodes_least", &culm.internodes_least, 2, 100},
                {"internodes_most", &culm.internodes_most, 2, 200}});
  if (culm.internodes_most < culm.internodes_least) {
    entry.at("internodes_most").fail("must not be below internodes_least");
  }
  return culm;
}

NormalCloud cloud_of(const data::JsonReader& entry) {
  NormalCloud cloud;
  read_numbers(entry,
               {{"expectation_deg", &cloud.expectation, 0.0, 89.0},
                {"entropy_deg", &cloud.entropy, 0.0, 90.0},
                {"hyper_entropy_deg", &cloud.hyper_entropy, 0.0, 90.0},
                {"low_deg", &cloud.low, 0.0, 89.0},
                {"high_deg", &cloud.high, 0.0, 89.0}},
               {"values"});
  try {
    check(cloud);
  } catch (const UsageError& error) {
    entry.at("expectation_deg").fail(error.message());
  }
  return cloud;
}

CulmBranching branches_of(const data::JsonReader& entry) {
  const data::JsonReader angle = entry.at("angle");
  CulmBranching branches;
  read_numbers(entry,
               {{"angle_sd_deg", &branches.angle_sd_deg, 0.0, 30.0},
                {"mu", &branches.mu, 3.56994, 4.0},
                {"pair_spread_deg", &branches.pair_spread_deg, 0.0, 180.0},
                {"second_length", &branches.second_length, 0.1, 1.0},
                {"length_low", &branches.length_low, 0.1, 1.0},
                {"bend_deg", &branches.bend_deg, 0.0, 120.0},
                {"bend_sd_deg", &branches.bend_sd_deg, 0.0, 60.0},
                {"tip_bend_deg", &branches.tip_bend_deg, 0.0, 170.0},
                {"thickness", &branches.thickness, 0.0005, 0.2},
                {"thickest", &branches.thickest, 0.01, 1.0},
                {"segments", &branches.segments, 1, 20}},
               {"angle", "length_high"});
  branches.angle = cloud_of(angle);
  branches.values = static_cast<std::size_t>(whole_number(angle.at("values"), 1, 1000));
  branches.length_high = entry.at("length_high").number_between(branches.length_low, 1.0);
  return branches;
}

CulmTwigs twigs_of(const data::JsonReader& entry) {
  CulmTwigs twigs;
  read_numbers(entry,
               {{"spacing_m", &twigs.spacing_m, 0.01, 10.0},
                {"from", &twigs.from, 0.0, 0.95},
                {"angle_deg", &twigs.angle_deg, 0.0, 120.0},
                {"angle_sd_deg", &twigs.angle_sd_deg, 0.0, 60.0},
                {"relative_length", &twigs.relative_length, 0.01, 2.0},
                {"tip_length", &twigs.tip_length, 0.0, 1.0},
                {"droop", &twigs.droop, 0.0, 0.5},
                {"least", &twigs.least, 1, 50}},
               {"most"});
  twigs.most = whole_number(entry.at("most"), twigs.least, 50);
  return twigs;
}

LeafLight light_of(const data::JsonReader& entry) {
  LeafLight light;
  read_numbers(entry,
               {{"outer", &light.outer, 0.0, 1.0},
                {"height", &light.height, 0.0, 1.0},
                {"sun", &light.sun, 0.0, 1.0},
                {"order", &light.order, 0.0, 1.0},
                {"sd", &light.sd, 0.0, 1.0}});
  constexpr double kRounding = 1e-9;
  if (std::abs(light.outer + light.height + light.sun + light.order - 1.0) > kRounding) {
    entry.at("outer").fail("the weights outer, height, sun and order must sum to 1");
  }
  return light;
}

/// From dark to bright in equal steps.
std::vector<std::shared_ptr<const Texture>> drawn_pictures(const data::JsonReader& entry) {
  const int grades = whole_number(entry.at("grades"), 1, 10);
  const int size = whole_number(entry.at("picture_size"), 16, 1024);
  const Color dark = color_of(entry.at("dark_color"));
  const Color bright = color_of(entry.at("bright_color"));
  std::vector<std::shared_ptr<const Texture>> pictures;
  for (int i = 0; i < grades; ++i) {
    const double share = grades == 1 ? 0.5 : static_cast<double>(i) / (grades - 1);
    Color color{};
    for (std::size_t k = 0; k < 3; ++k) color[k] = dark[k] + share * (bright[k] - dark[k]);
    pictures.push_back(std::make_shared<const Texture>(
        bamboo_leaf_picture(static_cast<std::size_t>(size), color, i)));
  }
  return pictures;
}

/// The files in the folder of the preset.
std::vector<std::shared_ptr<const Texture>> read_pictures(const data::JsonReader& entry) {
  const auto names = entry.at("pictures").texts();
  constexpr std::size_t kMost = 10;
  if (names.empty() || names.size() > kMost) {
    entry.at("pictures").fail("must list one to ten PNG files");
  }
  std::vector<std::shared_ptr<const Texture>> pictures;
  for (const std::string& name : names) {
    const auto file = std::filesystem::path(entry.file()).parent_path() / name;
    pictures.push_back(
        std::make_shared<const Texture>(texture_from_png(read_file(file), file.string())));
    if (color_weight(*pictures.back()) == 0.0) {
      throw InputError("is completely transparent", {.file = file.string()});
    }
  }
  return pictures;
}

CulmLeaves leaves_of(const data::JsonReader& entry) {
  CulmLeaves leaves;
  read_numbers(entry,
               {{"length_m", &leaves.length_m, 0.005, 3.0},
                {"crown_radius_m", &leaves.crown_radius_m, 0.01, 60.0},
                {"aspect", &leaves.aspect, 0.05, 2.0},
                {"droop", &leaves.droop, 0.0, 3.0},
                {"leaf_aspect", &leaves.leaf_aspect, 0.02, 1.0},
                {"leaf_length", &leaves.leaf_length, 0.05, 1.0},
                {"per_twig", &leaves.per_twig, 1, 20},
                {"picture_size", &leaves.picture_size, 16, 1024},
                {"leaves_per_spray", &leaves.leaves_per_spray, 1, 20}},
               {"form", "dark_color", "bright_color", "grades", "pictures", "light"});
  leaves.form = entry.at("form").one_of({"card", "crossed cards"}) == 0 ? LeafForm::kCard
                                                                        : LeafForm::kCrossedCards;
  leaves.light = light_of(entry.at("light"));
  if (!std::has_single_bit(static_cast<unsigned>(leaves.picture_size))) {
    entry.at("picture_size").fail("must be a power of two");
  }
  leaves.pictures =
      ranked_by_color(entry.has("pictures") ? read_pictures(entry) : drawn_pictures(entry));
  return leaves;
}

}  // namespace

std::unique_ptr<BambooBuilder> BambooBuilder::load(const std::filesystem::path& models,
                                                   const std::filesystem::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-bamboo/1");
  entry.at("crown").allow_only({"index_up", "index_down", "relative_hc"});
  BambooPreset preset;
  read_head(models, entry, {"culm", "branches", "twigs"}, preset);
  preset.culm = culm_of(entry.at("culm"));
  preset.branches = branches_of(entry.at("branches"));
  preset.twigs = twigs_of(entry.at("twigs"));
  preset.leaves = leaves_of(entry.at("leaves"));
  preset.leaf = color_of(entry.at("leaves").at("bright_color"));
  return std::make_unique<BambooBuilder>(std::move(preset));
}

}  // namespace silvafit::tree
