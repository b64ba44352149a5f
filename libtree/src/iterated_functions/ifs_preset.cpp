// SPDX-License-Identifier: MIT
// Reading models/ifs/*.json.
#include <algorithm>
#include <cmath>

#include "catalogue/preset_head.hpp"
#include "iterated_functions/ifs.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

/// The map as a matrix, three rows of four numbers.
AffineMap matrix_of(const data::JsonReader& entry) {
  const auto rows = rows_of<4>(entry);
  if (rows.size() != 3) entry.fail("must have three rows");
  AffineMap map;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) map.a[row][column] = rows[row][column];
  }
  map.b = {rows[0][3], rows[1][3], rows[2][3]};
  return map;
}

/// The map by the position of the copy on the trunk.
AffineMap placed(const data::JsonReader& entry) {
  const double azimuth = kRadian * entry.at("azimuth_deg").number_between(-360.0, 360.0);
  const double angle = kRadian * entry.at("angle_deg").number_between(0.0, 180.0);
  const double turn = kRadian * entry.at("turn_deg").number_between(-360.0, 360.0);
  const Point up{0.0, 0.0, 1.0};
  AffineMap map =
      turn_about(up, azimuth).after(turn_about({0.0, 1.0, 0.0}, angle).after(turn_about(up, turn)));
  map = scaled(map, entry.at("scale").number_between(0.01, 0.99));
  map.b = {0.0, 0.0, entry.at("at").number_between(0.0, 1.0)};
  return map;
}

IfsCopy copy_of(const data::JsonReader& entry) {
  constexpr int kMostOrders = 99;
  IfsCopy copy;
  if (entry.has("matrix")) {
    entry.allow_only({"matrix", "thickness", "continues", "orders", "probability"});
    copy.map = matrix_of(entry.at("matrix"));
    if (!(copy.map.spectral_norm() < 1.0)) {
      entry.at("matrix").fail("is not contractive: its largest singular value must be below 1");
    }
    copy.scale = length(copy.map.turn({0.0, 0.0, 1.0}));
  } else {
    entry.allow_only({"at",
                      "scale",
                      "angle_deg",
                      "azimuth_deg",
                      "turn_deg",
                      "thickness",
                      "continues",
                      "orders",
                      "probability"});
    copy.map = placed(entry);
    copy.scale = entry.at("scale").number_between(0.01, 0.99);
  }
  copy.thickness = entry.at("thickness").number_between(0.01, 1.0);
  copy.continues = entry.has("continues") && entry.at("continues").boolean();
  if (copy.continues && length(copy.map.b - Point{0.0, 0.0, 1.0}) > 1e-9) {
    entry.at(entry.has("matrix") ? "matrix" : "at")
        .fail("must start at the end of the trunk, at 1, because it continues the trunk");
  }
  if (entry.has("orders")) {
    const auto [from, to] = numbers_of<2>(entry.at("orders"));
    if (!(from >= 0.0 && from <= to && to <= kMostOrders && from == std::trunc(from) &&
          to == std::trunc(to))) {
      entry.at("orders").fail("must be [lowest, highest] order of the axes that bear the copy");
    }
    copy.from_order = static_cast<std::uint32_t>(from);
    copy.to_order = static_cast<std::uint32_t>(to);
  }
  return copy;
}

bool shares_orders(const IfsCopy& a, const IfsCopy& b) {
  return a.from_order <= b.to_order && b.from_order <= a.to_order;
}

/// The maps' probabilities, which are given for all or for none; then they are proportional to
/// |det A|, with a thousandth for a flat map.
void set_probabilities(const data::JsonReader& maps, std::vector<IfsCopy>& copies) {
  constexpr double kFlat = 0.001;
  const std::vector<data::JsonReader> entries = maps.items();
  const auto has_own = [](const data::JsonReader& map) { return map.has("probability"); };
  const bool is_given = std::ranges::any_of(entries, has_own);
  if (is_given && !std::ranges::all_of(entries, has_own)) {
    maps.fail("give a probability for every map or for none");
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < copies.size(); ++i) {
    copies[i].probability = is_given ? entries[i].at("probability").number_between(1e-6, 1.0)
                                     : std::max(std::abs(copies[i].map.determinant()), kFlat);
    sum += copies[i].probability;
  }
  constexpr double kRounding = 1e-9;
  if (is_given && !(std::abs(sum - 1.0) <= kRounding)) {
    maps.fail("the probabilities of the maps must sum to 1, not " + std::to_string(sum));
  }
  if (is_given) return;
  for (IfsCopy& copy : copies) copy.probability /= sum;
}

std::vector<IfsCopy> copies_of(const data::JsonReader& entry) {
  std::vector<IfsCopy> copies;
  bool branches = false;
  for (const data::JsonReader& map : entry.at("maps").items()) {
    const IfsCopy copy = copy_of(map);
    branches = branches || (!copy.continues && copy.from_order == 0);
    for (const IfsCopy& other : copies) {
      if (copy.continues && other.continues && shares_orders(copy, other)) {
        entry.at("maps").fail("two maps continue axes of the same order");
      }
    }
    copies.push_back(copy);
  }
  if (!branches) {
    entry.at("maps").fail("must have a map that places branches on the stem");
  }
  set_probabilities(entry.at("maps"), copies);
  return copies;
}

IfsTrunk trunk_of(const data::JsonReader& entry) {
  IfsTrunk trunk;
  read_numbers(entry,
               {{"segments", &trunk.segments, 1, 12},
                {"radius", &trunk.radius, 0.001, 0.5},
                {"tip_radius", &trunk.tip_radius, 0.0, 1.0},
                {"crookedness", &trunk.crookedness, 0.0, 0.3}});
  return trunk;
}

IfsVariation variation_of(const data::JsonReader& entry) {
  IfsVariation variation;
  read_numbers(entry,
               {{"angle_deg", &variation.angle_deg, 0.0, 90.0},
                {"azimuth_deg", &variation.azimuth_deg, 0.0, 180.0},
                {"scale", &variation.scale, 0.0, 0.5}});
  return variation;
}

IfsLimits limits_of(const data::JsonReader& entry) {
  IfsLimits limits;
  read_numbers(entry,
               {{"depth", &limits.depth, 1, 64}, {"least_scale", &limits.least_scale, 0.0, 0.9}});
  return limits;
}

IfsLeaves leaves_of(const data::JsonReader& entry) {
  IfsLeaves leaves{.count = static_cast<std::size_t>(whole_number(entry.at("count"), 0, 20000))};
  read_numbers(
      entry,
      {{"length", &leaves.length, 0.001, 1.0}, {"angle_deg", &leaves.angle_deg, 0.0, 180.0}},
      {"count", "look"});
  return leaves;
}

/// Copies without variation, counted by depth and order before anything is grown, so that a file
/// with too many copies is rejected when it is read.
void check_number(const data::JsonReader& entry, const IfsPreset& preset) {
  IfsPreset even = preset;
  even.variation = {};
  even.leaves.count = 0;
  even.limits.most_copies = preset.limits.most_copies / 2;
  Random random(1);
  try {
    const Skeleton skeleton = grow_ifs(even, random);
    if (skeleton.axes.size() < 2) {
      entry.at("recursion").fail("leaves no branch");
    }
  } catch (const GeometryError& error) {
    entry.at("recursion").fail(error.message());
  }
}

}  // namespace

std::unique_ptr<IfsBuilder> IfsBuilder::load(const std::filesystem::path& models,
                                             const std::filesystem::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-ifs/1");
  IfsPreset preset;
  read_head(models, entry, {"trunk", "head", "maps", "variation", "recursion"}, preset);
  preset.copies = copies_of(entry);
  preset.trunk = trunk_of(entry.at("trunk"));
  preset.variation = variation_of(entry.at("variation"));
  preset.limits = limits_of(entry.at("recursion"));
  preset.leaves = leaves_of(entry.at("leaves"));
  if (entry.has("head")) preset.head = entry.at("head").number_between(0.0, 0.95);
  preset.style.leaves.push_back(leaf_look_of(entry.at("leaves").at("look")));
  preset.leaf = preset.style.leaves.front().color;
  check_number(entry, preset);
  return std::make_unique<IfsBuilder>(std::move(preset));
}

Skeleton IfsBuilder::grow_freely(double /*h_m*/, Random& random) const {
  return grow_ifs(preset_, random);
}

Skeleton IfsBuilder::drawn(double /*h_m*/, bool has_leaves, Random& random) const {
  return grow_ifs(preset_, random, has_leaves);
}

}  // namespace silvafit::tree
