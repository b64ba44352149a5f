// SPDX-License-Identifier: MIT
// Reading models/ifs/*.json.
#include <cmath>

#include "catalogue/json_entry.hpp"
#include "catalogue/leafy_shoots_entry.hpp"
#include "catalogue/preset_head.hpp"
#include "mesh/leaf_look.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/tree/fitted_skeleton.hpp"
#include "silvafit/tree/ifs.hpp"

namespace silvafit::tree {
namespace {

/// The map as a matrix, three rows of four numbers.
AffineMap matrix_of(const JsonEntry& entry) {
  const auto rows = entry.get<std::array<std::array<double, 4>, 3>>("matrix");
  AffineMap map;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) map.a[row][column] = rows[row][column];
  }
  map.b = {rows[0][3], rows[1][3], rows[2][3]};
  return map;
}

/// The map by the position of the copy on the trunk.
AffineMap placed(const JsonEntry& entry) {
  const double azimuth = kRadian * entry.number("azimuth_deg", -360.0, 360.0);
  const double angle = kRadian * entry.number("angle_deg", 0.0, 180.0);
  const double turn = kRadian * entry.number("turn_deg", -360.0, 360.0);
  const Point up{0.0, 0.0, 1.0};
  AffineMap map =
      turn_about(up, azimuth).after(turn_about({0.0, 1.0, 0.0}, angle).after(turn_about(up, turn)));
  map = scaled(map, entry.number("scale", 0.01, 0.99));
  map.b = {0.0, 0.0, entry.number("at", 0.0, 1.0)};
  return map;
}

IfsCopy copy_of(const JsonEntry& entry) {
  constexpr int kMostOrders = 99;
  IfsCopy copy;
  if (entry.has("matrix")) {
    entry.allow_only({"matrix", "thickness", "continues", "orders", "probability"});
    copy.map = matrix_of(entry);
    if (!(copy.map.spectral_norm() < 1.0)) {
      throw InputError("is not contractive: its largest singular value must be below 1",
                       entry.place_of("matrix"));
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
    copy.scale = entry.number("scale", 0.01, 0.99);
  }
  copy.thickness = entry.number("thickness", 0.01, 1.0);
  copy.continues = entry.has("continues") && entry.get<bool>("continues");
  if (copy.continues && length(copy.map.b - Point{0.0, 0.0, 1.0}) > 1e-9) {
    throw InputError("must start at the end of the trunk, at 1, because it continues the trunk",
                     entry.place_of(entry.has("matrix") ? "matrix" : "at"));
  }
  if (entry.has("orders")) {
    const auto orders = entry.get<std::array<int, 2>>("orders");
    if (!(orders[0] >= 0 && orders[0] <= orders[1] && orders[1] <= kMostOrders)) {
      throw InputError("must be [lowest, highest] order of the axes that bear the copy",
                       entry.place_of("orders"));
    }
    copy.from_order = static_cast<std::uint32_t>(orders[0]);
    copy.to_order = static_cast<std::uint32_t>(orders[1]);
  }
  return copy;
}

bool shares_orders(const IfsCopy& a, const IfsCopy& b) {
  return a.from_order <= b.to_order && b.from_order <= a.to_order;
}

std::vector<IfsCopy> copies_of(const JsonEntry& entry) {
  std::vector<IfsCopy> copies;
  bool branches = false;
  for (const JsonEntry& map : entry.children("maps")) {
    const IfsCopy copy = copy_of(map);
    branches = branches || (!copy.continues && copy.from_order == 0);
    for (const IfsCopy& other : copies) {
      if (copy.continues && other.continues && shares_orders(copy, other)) {
        throw InputError("two maps continue axes of the same order", entry.place_of("maps"));
      }
    }
    copies.push_back(copy);
  }
  if (!branches) {
    throw InputError("must have a map that places branches on the stem", entry.place_of("maps"));
  }
  return copies;
}

/// With the maps' probabilities, which are given for all or for none.
IteratedFunctionSystem system_of(const JsonEntry& entry, const std::vector<IfsCopy>& copies) {
  std::vector<AffineMap> maps;
  std::vector<double> probabilities;
  const std::vector<JsonEntry> entries = entry.children("maps");
  for (std::size_t i = 0; i < copies.size(); ++i) {
    maps.push_back(copies[i].map);
    if (entries[i].has("probability")) {
      probabilities.push_back(entries[i].number("probability", 1e-6, 1.0));
    }
  }
  try {
    return IteratedFunctionSystem(std::move(maps), std::move(probabilities));
  } catch (const DomainError& error) {
    throw InputError(error.message(), entry.place_of("maps"));
  }
}

IfsTrunk trunk_of(const JsonEntry& entry) {
  entry.allow_only({"segments", "radius", "tip_radius", "crookedness"});
  return {.segments = whole_number(entry, "segments", 1, 12),
          .radius = entry.number("radius", 0.001, 0.5),
          .tip_radius = entry.number("tip_radius", 0.0, 1.0),
          .crookedness = entry.number("crookedness", 0.0, 0.3)};
}

IfsVariation variation_of(const JsonEntry& entry) {
  entry.allow_only({"angle_deg", "azimuth_deg", "scale"});
  return {.angle_deg = entry.number("angle_deg", 0.0, 90.0),
          .azimuth_deg = entry.number("azimuth_deg", 0.0, 180.0),
          .scale = entry.number("scale", 0.0, 0.5)};
}

IfsLimits limits_of(const JsonEntry& entry) {
  entry.allow_only({"depth", "least_scale"});
  return {.depth = whole_number(entry, "depth", 1, 64),
          .least_scale = entry.number("least_scale", 0.0, 0.9)};
}

IfsLeaves leaves_of(const JsonEntry& entry) {
  entry.allow_only({"count", "length", "angle_deg", "look"});
  return {.count = static_cast<std::size_t>(whole_number(entry, "count", 0, 20000)),
          .length = entry.number("length", 0.001, 1.0),
          .angle_deg = entry.number("angle_deg", 0.0, 180.0)};
}

/// Copies without variation, counted by depth and order before anything is grown, so that a file
/// with too many copies is rejected when it is read.
void check_number(const JsonEntry& entry, const IfsPreset& preset) {
  IfsPreset even = preset;
  even.variation = {};
  even.leaves.count = 0;
  even.limits.most_copies = preset.limits.most_copies / 2;
  Random random(1);
  try {
    const Skeleton skeleton = grow_ifs(even, random);
    if (skeleton.axes.size() < 2) {
      throw InputError("leaves no branch", entry.place_of("recursion"));
    }
  } catch (const GeometryError& error) {
    throw InputError(error.message(), entry.place_of("recursion"));
  }
}

}  // namespace

std::unique_ptr<IfsBuilder> IfsBuilder::load(const std::filesystem::path& models,
                                             const std::filesystem::path& file) {
  const JsonEntry entry = JsonEntry::load(file, "silvafit-ifs/1");
  entry.allow_only({"schema",
                    "name",
                    "title",
                    "species",
                    "taper",
                    "crown",
                    "trunk",
                    "head",
                    "largest_gap",
                    "maps",
                    "variation",
                    "recursion",
                    "leaves",
                    "leafy_shoots",
                    "bark_color",
                    "bark",
                    "basis"});
  PresetHead head = preset_head_of(models, entry);
  const std::vector<IfsCopy> copies = copies_of(entry);
  IfsPreset preset{.system = system_of(entry, copies),
                   .copies = copies,
                   .trunk = trunk_of(entry.child("trunk")),
                   .variation = variation_of(entry.child("variation")),
                   .limits = limits_of(entry.child("recursion")),
                   .leaves = leaves_of(entry.child("leaves"))};
  if (entry.has("head")) preset.fit.head = entry.number("head", 0.0, 0.95);
  preset.fit.largest_gap = largest_gap_of(entry);
  preset.style.bark = color_of(entry, "bark_color");
  preset.style.bark_kind = bark_kind_of(entry);
  if (entry.has("leafy_shoots")) {
    preset.style.shoots = leafy_shoots_of(entry.child("leafy_shoots"));
  }
  preset.style.leaves.push_back(leaf_look_of(entry.child("leaves").child("look")));
  check_number(entry, preset);
  return std::make_unique<IfsBuilder>(std::move(head), std::move(preset));
}

IfsBuilder::IfsBuilder(PresetHead head, IfsPreset preset)
    : Builder(BuilderKind::kIfs, std::move(head)), ifs_(std::move(preset)) {}

Skeleton IfsBuilder::grow_freely(double /*h_m*/, Random& random) const {
  return grow_ifs(ifs_, random);
}

Skeleton IfsBuilder::grow_skeleton(const TreeShape& shape,
                                   const Crown& crown,
                                   Random& random) const {
  return fit_to_measurements(
      grow_freely(shape.h_m, random), shape, crown, this->preset().taper, ifs_.fit);
}

Skeleton IfsBuilder::grow_skeleton_for(const MeshOptions& mesh,
                                       const TreeShape& shape,
                                       const Crown& crown,
                                       Random& random) const {
  const bool has_leaves = !shows_shoots(ifs_.style, mesh);
  return fit_to_measurements(
      grow_ifs(ifs_, random, has_leaves), shape, crown, this->preset().taper, ifs_.fit);
}

Mesh IfsBuilder::build_mesh(const Skeleton& skeleton,
                            const Crown& crown,
                            Random& random,
                            const MeshOptions& options) const {
  return build_smooth_mesh(skeleton, crown, ifs_.style, random, options);
}

}  // namespace silvafit::tree
