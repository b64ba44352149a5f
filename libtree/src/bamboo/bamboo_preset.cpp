// SPDX-License-Identifier: MIT
#include <bit>
#include <cmath>

#include "bamboo/bamboo_leaves.hpp"
#include "catalogue/preset_head.hpp"
#include "silvafit/tree/bamboo.hpp"

namespace silvafit::tree {
namespace {

CulmStyle culm_of(const JsonEntry& entry) {
  entry.allow_only({"bend_deg",
                    "bend_sd_deg",
                    "sun_azimuth_deg",
                    "sun_azimuth_sd_deg",
                    "nod",
                    "internode_m",
                    "internodes_least",
                    "internodes_most",
                    "internodes_sd",
                    "internode_base",
                    "internode_top",
                    "longest_at",
                    "internode_length_sd",
                    "ridge_height",
                    "ridge_m"});
  CulmStyle culm;
  culm.bend_deg = entry.number("bend_deg", 0.0, 60.0);
  culm.bend_sd_deg = entry.number("bend_sd_deg", 0.0, 30.0);
  culm.sun_azimuth_deg = entry.number("sun_azimuth_deg", 0.0, 360.0);
  culm.sun_azimuth_sd_deg = entry.number("sun_azimuth_sd_deg", 0.0, 360.0);
  culm.nod = entry.number("nod", 0.0, 0.2);
  culm.internode_m = entry.number("internode_m", 0.01, 2.0);
  culm.internodes_least = whole_number(entry, "internodes_least", 2, 100);
  culm.internodes_most = whole_number(entry, "internodes_most", 2, 200);
  if (culm.internodes_most < culm.internodes_least) {
    throw InputError("must not be below internodes_least", entry.place_of("internodes_most"));
  }
  culm.internodes_sd = entry.number("internodes_sd", 0.0, 0.3);
  culm.internode_base = entry.number("internode_base", 0.01, 1.0);
  culm.internode_top = entry.number("internode_top", 0.01, 1.0);
  culm.longest_at = entry.number("longest_at", 0.05, 0.95);
  culm.internode_length_sd = entry.number("internode_length_sd", 0.0, 0.3);
  culm.ridge_height = entry.number("ridge_height", 0.0, 0.5);
  culm.ridge_m = entry.number("ridge_m", 0.001, 0.2);
  return culm;
}

NormalCloud cloud_of(const JsonEntry& entry) {
  NormalCloud cloud{.expectation = entry.number("expectation_deg", 0.0, 89.0),
                    .entropy = entry.number("entropy_deg", 0.0, 90.0),
                    .hyper_entropy = entry.number("hyper_entropy_deg", 0.0, 90.0),
                    .low = entry.number("low_deg", 0.0, 89.0),
                    .high = entry.number("high_deg", 0.0, 89.0)};
  try {
    check(cloud);
  } catch (const UsageError& error) {
    throw InputError(error.message(), entry.place_of("expectation_deg"));
  }
  return cloud;
}

CulmBranching branches_of(const JsonEntry& entry) {
  entry.allow_only({"angle",
                    "angle_sd_deg",
                    "mu",
                    "pair_spread_deg",
                    "second_length",
                    "length_low",
                    "length_high",
                    "bend_deg",
                    "bend_sd_deg",
                    "thickness",
                    "thickest",
                    "segments"});
  const JsonEntry angle = entry.child("angle");
  angle.allow_only(
      {"expectation_deg", "entropy_deg", "hyper_entropy_deg", "low_deg", "high_deg", "values"});
  CulmBranching branches;
  branches.angle = cloud_of(angle);
  branches.values = static_cast<std::size_t>(whole_number(angle, "values", 1, 1000));
  branches.angle_sd_deg = entry.number("angle_sd_deg", 0.0, 30.0);
  branches.mu = entry.number("mu", 3.56994, 4.0);
  branches.pair_spread_deg = entry.number("pair_spread_deg", 0.0, 180.0);
  branches.second_length = entry.number("second_length", 0.1, 1.0);
  branches.length_low = entry.number("length_low", 0.1, 1.0);
  branches.length_high = entry.number("length_high", branches.length_low, 1.0);
  branches.bend_deg = entry.number("bend_deg", 0.0, 120.0);
  branches.bend_sd_deg = entry.number("bend_sd_deg", 0.0, 60.0);
  branches.thickness = entry.number("thickness", 0.0005, 0.2);
  branches.thickest = entry.number("thickest", 0.01, 1.0);
  branches.segments = whole_number(entry, "segments", 1, 20);
  return branches;
}

CulmTwigs twigs_of(const JsonEntry& entry) {
  entry.allow_only({"spacing_m",
                    "least",
                    "most",
                    "from",
                    "angle_deg",
                    "angle_sd_deg",
                    "relative_length",
                    "tip_length",
                    "droop"});
  CulmTwigs twigs;
  twigs.spacing_m = entry.number("spacing_m", 0.01, 10.0);
  twigs.least = whole_number(entry, "least", 1, 50);
  twigs.most = whole_number(entry, "most", twigs.least, 50);
  twigs.from = entry.number("from", 0.0, 0.95);
  twigs.angle_deg = entry.number("angle_deg", 0.0, 120.0);
  twigs.angle_sd_deg = entry.number("angle_sd_deg", 0.0, 60.0);
  twigs.relative_length = entry.number("relative_length", 0.01, 2.0);
  twigs.tip_length = entry.number("tip_length", 0.0, 1.0);
  twigs.droop = entry.number("droop", 0.0, 0.5);
  return twigs;
}

LeafLight light_of(const JsonEntry& entry) {
  entry.allow_only({"outer", "height", "sun", "order", "sd"});
  const LeafLight light{.outer = entry.number("outer", 0.0, 1.0),
                        .height = entry.number("height", 0.0, 1.0),
                        .sun = entry.number("sun", 0.0, 1.0),
                        .order = entry.number("order", 0.0, 1.0),
                        .sd = entry.number("sd", 0.0, 1.0)};
  constexpr double kRounding = 1e-9;
  if (std::abs(light.outer + light.height + light.sun + light.order - 1.0) > kRounding) {
    throw InputError("the weights outer, height, sun and order must sum to 1",
                     entry.place_of("outer"));
  }
  return light;
}

LeafForm form_of(const JsonEntry& entry) {
  const auto form = entry.get<std::string>("form");
  if (form == "card") return LeafForm::kCard;
  if (form == "crossed cards") return LeafForm::kCrossedCards;
  throw InputError("must be \"card\" or \"crossed cards\"", entry.place_of("form"));
}

/// From dark to bright in equal steps.
std::vector<std::shared_ptr<const Texture>> drawn_pictures(const JsonEntry& entry) {
  const int grades = whole_number(entry, "grades", 1, 10);
  const int size = whole_number(entry, "picture_size", 16, 1024);
  const Color dark = color_of(entry, "dark_color");
  const Color bright = color_of(entry, "bright_color");
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
std::vector<std::shared_ptr<const Texture>> read_pictures(const JsonEntry& entry) {
  const auto names = entry.get<std::vector<std::string>>("pictures");
  constexpr std::size_t kMost = 10;
  if (names.empty() || names.size() > kMost) {
    throw InputError("must list one to ten PNG files", entry.place_of("pictures"));
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

CulmLeaves leaves_of(const JsonEntry& entry) {
  entry.allow_only({"per_twig",
                    "length_m",
                    "crown_radius_m",
                    "aspect",
                    "droop",
                    "form",
                    "picture_size",
                    "dark_color",
                    "bright_color",
                    "grades",
                    "pictures",
                    "leaves_per_spray",
                    "leaf_aspect",
                    "leaf_length",
                    "light"});
  CulmLeaves leaves;
  leaves.per_twig = whole_number(entry, "per_twig", 1, 20);
  leaves.length_m = entry.number("length_m", 0.005, 3.0);
  leaves.crown_radius_m = entry.number("crown_radius_m", 0.01, 60.0);
  leaves.aspect = entry.number("aspect", 0.05, 2.0);
  leaves.droop = entry.number("droop", 0.0, 3.0);
  leaves.form = form_of(entry);
  leaves.light = light_of(entry.child("light"));
  leaves.picture_size = whole_number(entry, "picture_size", 16, 1024);
  if (!std::has_single_bit(static_cast<unsigned>(leaves.picture_size))) {
    throw InputError("must be a power of two", entry.place_of("picture_size"));
  }
  leaves.leaves_per_spray = whole_number(entry, "leaves_per_spray", 1, 20);
  leaves.leaf_aspect = entry.number("leaf_aspect", 0.02, 1.0);
  leaves.leaf_length = entry.number("leaf_length", 0.05, 1.0);
  leaves.pictures =
      ranked_by_color(entry.has("pictures") ? read_pictures(entry) : drawn_pictures(entry));
  return leaves;
}

}  // namespace

BambooPreset BambooPreset::load(const std::filesystem::path& models,
                                const std::filesystem::path& file) {
  const JsonEntry entry = JsonEntry::load(file, "silvafit-bamboo/1");
  entry.allow_only({"schema",
                    "name",
                    "title",
                    "species",
                    "taper",
                    "crown",
                    "culm",
                    "branches",
                    "twigs",
                    "leaves",
                    "culm_color",
                    "basis"});
  entry.child("crown").allow_only({"index_up", "index_down", "relative_hc"});
  return {.head = preset_head_of(models, entry),
          .culm = culm_of(entry.child("culm")),
          .branches = branches_of(entry.child("branches")),
          .twigs = twigs_of(entry.child("twigs")),
          .leaves = leaves_of(entry.child("leaves")),
          .culm_color = color_of(entry, "culm_color")};
}

}  // namespace silvafit::tree
