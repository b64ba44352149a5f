// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "bamboo/bamboo.hpp"
#include "bamboo/culm.hpp"
#include "bamboo/logistic_map.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

constexpr double kFlattest = 2.0 * kRadian;

/// A first-order branch before its points are computed.
struct Shoot {
  Point base{};
  double culm_radius_m = 0.0;
  double azimuth_rad = 0.0;  ///< from north over east
  double elevation_rad = 0.0;
  double bend_rad = 0.0;
  double length_share = 1.0;   ///< relative to the distance of the crown curve
  std::optional<Point> tip{};  ///< where it must end
  Random random;               ///< for its twigs
  bool is_second = false;      ///< of its node
};

Point outward(double azimuth_rad) { return {std::sin(azimuth_rad), std::cos(azimuth_rad), 0.0}; }

/// The smaller angle between two azimuths, in [0, pi].
double angle_between(double a, double b) {
  const double off = std::fmod(std::abs(a - b), kTwoPi);
  return std::min(off, kTwoPi - off);
}

class BambooGrower {
 public:
  BambooGrower(const TreeShape& shape,
               const Crown& crown,
               const BambooPreset& preset,
               Random& random)
      : shape_(shape),
        crown_(crown),
        preset_(preset),
        culm_(shape, crown, preset.culm, random),
        angles_(angles(random)),
        azimuths_(preset.branches.mu, start_of(preset.branches.mu, random)),
        side_rad_(random.uniform(0.0, kTwoPi)),
        key_(random.bits()) {
    const double mean = 0.5 * crown.radii().width_m();
    constexpr double kMost = 3.0;
    leaf_m_ = preset.leaves.length_m * std::min(mean / preset.leaves.crown_radius_m, kMost);
    // A crown may be wide and flat.
    leaf_m_ = std::min(leaf_m_, 0.2 * (shape.h_m - shape.hcb_m));
  }

  Skeleton grow() {
    skeleton_.add_axis(0, 0, culm_.points(preset_.taper));
    skeleton_.notes = culm_.notes();
    std::vector<Shoot> shoots = planned_shoots();
    lead_to_radii(shoots);
    for (Shoot& shoot : shoots) add_branch(shoot);
    return std::move(skeleton_);
  }

 private:
  /// The values that the culm's branches draw from.
  std::vector<double> angles(Random& random) const {
    NormalCloud cloud = preset_.branches.angle;
    const double drawn = random.normal(cloud.expectation, preset_.branches.angle_sd_deg);
    cloud.expectation =
        std::clamp(shape_.culm.branch_angle_deg.value_or(drawn), cloud.low, cloud.high);
    return cloud_angles(cloud, preset_.branches.values, random);
  }

  static double start_of(double mu, Random& random) {
    for (;;) {
      const double x0 = random.uniform(0.01, 0.99);
      if (LogisticMap::is_chaotic(mu, x0)) return x0;
    }
  }

  // ---- First order ----------------------------------------------------------------------------

  /// Whether the crown is present all around the culm.
  bool has_room(double z_m) const {
    const Point at = culm_.at(z_m);
    const double away = std::hypot(at.x, at.y);
    constexpr double kRoom = 0.7;
    return away == 0.0 || away < kRoom * crown_.radius_m(at.x, at.y) * crown_.relative_width(z_m);
  }

  /// Nodes with branches; the first is the crown base. At least two, so that a branch can be moved
  /// to each of the four measured radii.
  std::vector<CulmNode> bearing_nodes() const {
    const double length = shape_.h_m - shape_.hcb_m;
    constexpr double kHighest = 0.985;
    const double top = shape_.hcb_m + kHighest * length;
    std::vector<CulmNode> bearing;
    for (const CulmNode& node : culm_.nodes()) {
      if (node.z_m >= shape_.hcb_m && node.z_m < top && (bearing.empty() || has_room(node.z_m))) {
        bearing.push_back(node);
      }
    }
    if (bearing.empty() || bearing.front().z_m > shape_.hcb_m) {
      bearing.insert(bearing.begin(), {shape_.hcb_m, 0});
    }
    if (bearing.size() < 2) {
      const double share = std::min(0.4 * length, 0.5 * (crown_.hc_m() - crown_.hcb_m()));
      bearing.push_back({shape_.hcb_m + share, bearing.back().number + 1});
    }
    return bearing;
  }

  std::vector<Shoot> planned_shoots() {
    std::vector<double> x;
    const auto azimuth_of = [&](std::uint32_t number) {
      // Numbered from the ground, so that another crown base does not change the other nodes.
      while (x.size() <= number) x.push_back(azimuths_.next());
      const double other_side = number % 2 == 0 ? 0.0 : std::numbers::pi;
      return side_rad_ + kTwoPi * x[number] + other_side;
    };
    std::vector<Shoot> shoots;
    for (const CulmNode& node : bearing_nodes()) {
      Random random(key_, node.number);
      const double azimuth = azimuth_of(node.number);
      const double half_spread = 0.5 * preset_.branches.pair_spread_deg * kRadian;
      const bool first_is_left = random.below(2) == 0;
      const double radius = culm_radius_m(node.z_m);
      for (const bool is_second : {false, true}) {
        const double turn = is_second == first_is_left ? half_spread : -half_spread;
        shoots.push_back(shoot_of(node, radius, azimuth + turn, is_second, random));
      }
    }
    return shoots;
  }

  double culm_radius_m(double z_m) const {
    return preset_.taper.radii_m(std::span(&z_m, 1), shape_.h_m, shape_.dbh_cm).front();
  }

  Shoot shoot_of(const CulmNode& node,
                 double culm_radius_m,
                 double azimuth_rad,
                 bool is_second,
                 Random& random) const {
    const CulmBranching& branches = preset_.branches;
    const double elevation = angles_[random.below(angles_.size())];
    // The thin upper branches hang, to the side to which the culm nods.
    const double share_of_crown = (node.z_m - shape_.hcb_m) / (shape_.h_m - shape_.hcb_m);
    const double hangs = std::pow(share_of_crown, 5.0);
    const double nod_rad = culm_.lean_azimuth_rad();
    const double turn = hangs * std::remainder(nod_rad - azimuth_rad, kTwoPi);
    const double bend = random.normal(std::lerp(branches.bend_deg, branches.tip_bend_deg, hangs),
                                      branches.bend_sd_deg);
    const double share = random.uniform(branches.length_low, branches.length_high);
    return {.base = crown_.confine(culm_.at(node.z_m)),
            .culm_radius_m = culm_radius_m,
            .azimuth_rad = azimuth_rad + turn,
            .elevation_rad = elevation * kRadian,
            .bend_rad = std::clamp(bend, 0.0, 170.0) * kRadian,
            .length_share = is_second ? branches.second_length * share : share,
            .random = Random(random.bits()),
            .is_second = is_second};
  }

  /// In each measured direction the nearest branch ends at the widest point.
  void lead_to_radii(std::vector<Shoot>& shoots) const {
    for (std::size_t direction = 0; direction < Crown::kMeasured.size(); ++direction) {
      const Point tip = crown_.widest_point(direction);
      Shoot* best = nullptr;
      double least = std::numeric_limits<double>::infinity();
      for (Shoot& shoot : shoots) {
        if (shoot.tip) continue;
        const double cost = cost_of(shoot, tip);
        if (cost < least) {
          least = cost;
          best = &shoot;
        }
      }
      best->tip = tip;
      best->azimuth_rad = std::atan2(tip.x, tip.y);
    }
  }

  /// Distance of a branch from one that ends at a measured radius: its base relative to the crown
  /// length, its azimuth in half turns.
  double cost_of(const Shoot& shoot, Point tip) const {
    const double elevation = std::max(shoot.elevation_rad - 0.5 * shoot.bend_rad, kFlattest);
    const double wanted = tip.z - std::hypot(tip.x, tip.y) * std::tan(elevation);
    const double base = std::max(wanted, shape_.hcb_m);
    constexpr double kSecond = 0.2;
    return std::abs(shoot.base.z - base) / (shape_.h_m - shape_.hcb_m) +
           angle_between(shoot.azimuth_rad, std::atan2(tip.x, tip.y)) / std::numbers::pi +
           (shoot.is_second ? kSecond : 0.0) + (shoot.base.z > tip.z ? 1.0 : 0.0);
  }

  /// Shorter branches are not drawn.
  double shortest_m(double radius_m) const {
    constexpr double kShortest = 0.05;
    return kShortest * std::min(radius_m, shape_.h_m - shape_.hcb_m);
  }

  /// End of a branch that is not moved to a radius.
  Point free_tip(const Shoot& shoot) const {
    const double chord = shoot.elevation_rad - 0.5 * shoot.bend_rad;
    const bool hangs = shoot.base.z > crown_.hc_m();
    const double elevation = hangs ? chord : std::max(chord, kFlattest);
    const Point flat = outward(shoot.azimuth_rad);
    const double radius = crown_.radius_m(flat.x, flat.y);
    const double from_vertical = 0.5 * std::numbers::pi - std::max(elevation, kFlattest);
    const double distance =
        crown_.matching_distance_m(std::min(shoot.base.z, crown_.h_m()), from_vertical, radius);
    Point along = std::cos(elevation) * flat + Point{0.0, 0.0, std::sin(elevation)};
    // The culm may be nearer to the other side.
    constexpr double kMargin = 1.25;
    double wanted = kMargin * distance / std::cos(elevation);
    constexpr double kLong = 0.35;
    if (distance < kLong * radius && shoot.base.z < crown_.hc_m()) {
      // Low in a slender crown branches are steeper, because the crown leaves no other space.
      constexpr double kAway = 0.7;
      const Point there = kAway * radius * flat + Point{0.0, 0.0, crown_.hc_m()};
      along = direction(there - shoot.base);
      wanted = length(there - shoot.base);
    }
    double reach = crown_.length_inside_m(shoot.base, along, wanted);
    if (shoot.length_share * reach < shortest_m(radius)) {
      // The culm bows to the crown's surface there: the branch grows to its other side.
      along = {-along.x, -along.y, along.z};
      reach = crown_.length_inside_m(shoot.base, along, wanted);
    }
    // Between unequal radii the crown is concave: a part of a line inside it may be outside.
    reach = crown_.length_inside_m(shoot.base, along, shoot.length_share * reach);
    return shoot.base + reach * along;
  }

  /// An arch over the straight line from the base to the tip, bent as far as the crown allows.
  std::vector<Point> arch(const Shoot& shoot, Point tip, int segments) const {
    const Point chord = tip - shoot.base;
    const double span = length(chord);
    const Point along = direction(chord);
    const Point sideways =
        direction(cross(along, {0.0, 0.0, 1.0}), {-std::cos(shoot.azimuth_rad), 0.0, 0.0});
    const Point above = cross(sideways, along);
    std::vector<Point> line(static_cast<std::size_t>(segments) + 1);
    for (double bend = shoot.bend_rad;; bend *= 0.5) {
      constexpr double kStraight = 0.05;
      if (bend < kStraight) bend = 0.0;
      const Point start = std::cos(0.5 * bend) * along + std::sin(0.5 * bend) * above;
      const Point side = std::cos(0.5 * bend) * above - std::sin(0.5 * bend) * along;
      // V < 0: the tip hangs.
      const CubicBezier unit = bent_curve({}, start, side, 1.0, bend / kRadian, -1.0);
      const double scale = span / length(unit.control[3]);
      bool inside = true;
      for (int i = 0; i <= segments; ++i) {
        const double t = static_cast<double>(i) / segments;
        line[static_cast<std::size_t>(i)] = shoot.base + scale * unit.at(t);
        inside = inside && (i == 0 || i == segments || crown_.contains(line[i]));
      }
      if (inside || bend == 0.0) break;
    }
    line.back() = tip;
    for (std::size_t i = 1; i + 1 < line.size(); ++i) line[i] = crown_.confine(line[i]);
    return line;
  }

  void add_branch(Shoot& shoot) {
    const CulmBranching& branches = preset_.branches;
    const Point tip = shoot.tip.value_or(free_tip(shoot));
    const double span = length(tip - shoot.base);
    // Parts outside the crown curve are cut off and have no twigs.
    if (!shoot.tip && span < shortest_m(crown_.radius_m(tip.x, tip.y))) return;
    const std::vector<Point> line = arch(shoot, tip, branches.segments);
    const std::uint32_t axis = skeleton_.add_axis(1, 0);
    const double radius =
        std::max(std::min(0.5 * branches.thickness * span, branches.thickest * shoot.culm_radius_m),
                 kThinnestWoodM);
    for (std::size_t i = 0; i < line.size(); ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(line.size() - 1);
      skeleton_.add_point(
          line[i], i + 1 == line.size() ? 0.0 : std::max((1.0 - share) * radius, kThinnestWoodM));
    }
    add_twigs(axis, line, radius, span, shoot.random);
    add_leaf(axis, tip, line.back() - line[line.size() - 2], 1, shoot.random);
  }

  // ---- Second order and leaves ----------------------------------------------------------------

  void add_twigs(std::uint32_t bearer,
                 const std::vector<Point>& line,
                 double radius_m,
                 double span_m,
                 Random& random) {
    const CulmTwigs& twigs = preset_.twigs;
    const int number = std::clamp(
        static_cast<int>(span_m * (1.0 - twigs.from) / twigs.spacing_m), twigs.least, twigs.most);
    const bool begins_left = random.below(2) == 0;
    for (int i = 0; i < number; ++i) {
      const double along_share = (i + random.uniform(0.3, 0.7)) / number;
      const double share = twigs.from + (1.0 - twigs.from) * along_share;
      const double at = share * static_cast<double>(line.size() - 1);
      const std::size_t piece = std::min(static_cast<std::size_t>(at), line.size() - 2);
      const Point step = line[piece + 1] - line[piece];
      const Point base = crown_.confine(line[piece] + (at - static_cast<double>(piece)) * step);
      const double wanted =
          twigs.relative_length * span_m * (1.0 - (1.0 - twigs.tip_length) * along_share);
      const bool is_left = (i % 2 == 0) == begins_left;
      const double base_radius = std::max((1.0 - share) * radius_m, kThinnestWoodM);
      add_twig(bearer, base, direction(step), is_left, wanted, base_radius, random);
    }
  }

  void add_twig(std::uint32_t bearer,
                Point base,
                Point tangent,
                bool is_left,
                double wanted_m,
                double bearer_radius_m,
                Random& random) {
    const CulmTwigs& twigs = preset_.twigs;
    const Point sideways = direction(cross(tangent, {0.0, 0.0, 1.0}), {1.0, 0.0, 0.0});
    const Point above = cross(sideways, tangent);
    const double angle = random.normal(twigs.angle_deg, twigs.angle_sd_deg) * kRadian;
    // Nearly horizontal, in the plane of the branch's leaves.
    constexpr double kTilt = 0.35;
    const double tilt = random.uniform(-kTilt, kTilt);
    const Point away = (is_left ? -1.0 : 1.0) * std::cos(tilt) * sideways + std::sin(tilt) * above;
    const Point along = std::cos(angle) * tangent + std::sin(angle) * away;
    const double reach = crown_.length_inside_m(base, along, wanted_m);
    constexpr double kShortest = 0.05;
    if (reach < kShortest * wanted_m) return;
    const Point tip = base + reach * along;
    const Point middle =
        crown_.confine(base + 0.5 * reach * along + twigs.droop * reach * Point{0.0, 0.0, 1.0});
    const std::uint32_t axis = skeleton_.add_axis(skeleton_.axes[bearer].order + 1, bearer);
    constexpr double kOfBearer = 0.7;
    const double radius =
        std::max(std::min(0.5 * preset_.branches.thickness * reach, kOfBearer * bearer_radius_m),
                 kThinnestWoodM);
    skeleton_.add_point(base, radius);
    skeleton_.add_point(middle, std::max(0.5 * radius, kThinnestWoodM));
    skeleton_.add_point(tip, 0.0);
    const int leaves = preset_.leaves.per_twig;
    for (int i = 0; i < leaves; ++i) {
      const double share = (i + 1.0) / leaves;
      const Point at = share < 0.5 ? base + 2.0 * share * (middle - base)
                                   : middle + (2.0 * share - 1.0) * (tip - middle);
      // Leaves on both sides of a twig, the last one straight ahead.
      constexpr double kSpread = 0.6;
      const double spread = i + 1 == leaves ? 0.0 : (i % 2 == 0 ? kSpread : -kSpread);
      const Point across = direction(cross(along, {0.0, 0.0, 1.0}), sideways);
      add_leaf(axis, at, along + spread * across, 2, random);
    }
  }

  /// An image of leaves that hangs from a point and stays inside the crown.
  void add_leaf(
      std::uint32_t axis, Point at, Point outward_along, std::uint32_t order, Random& random) {
    const CulmLeaves& leaves = preset_.leaves;
    // A crown with very unequal radii is concave between them.
    at = crown_.confine(at);
    const double size = leaf_m_ * random.uniform(0.8, 1.2);
    const double roll = random.uniform(-0.5, 0.5);
    const double added = random.normal(0.0, leaves.light.sd);
    const Point hanging = direction(outward_along) - Point{0.0, 0.0, leaves.droop};
    Point along = direction(hanging);
    double room = crown_.length_inside_m(at, along, size);
    constexpr double kEnough = 0.6;
    if (room < kEnough * size) {
      // At the crown's surface it turns towards free space.
      const Point middle{0.0, 0.0, 0.5 * (shape_.hcb_m + shape_.h_m)};
      along = direction(along + 1.2 * direction(middle - at));
      room = crown_.length_inside_m(at, along, size);
    }
    constexpr double kLeast = 0.1;
    if (room < kLeast * size) return;
    const Point across = direction(cross(along, {0.0, 0.0, 1.0}), {1.0, 0.0, 0.0});
    const Point upper = cross(across, along);
    const Point facing = std::cos(roll) * upper + std::sin(roll) * across;
    const double light = leaf_light(
        leaves.light, crown_, preset_.culm.sun_azimuth_deg, at + 0.5 * room * along, order);
    const auto grades = static_cast<double>(std::max<std::size_t>(leaves.pictures.size(), 1));
    const double grade = std::clamp(std::floor((light + added) * grades), 0.0, grades - 1.0);
    skeleton_.leaves.push_back({.at = at,
                                .along = along,
                                .facing = facing,
                                .length_m = room,
                                .axis = axis,
                                .grade = static_cast<std::uint32_t>(grade)});
  }

  const TreeShape& shape_;
  const Crown& crown_;
  const BambooPreset& preset_;
  Culm culm_;
  std::vector<double> angles_;
  LogisticMap azimuths_;
  double side_rad_;  ///< of the branches at even nodes, before the logistic map is added
  std::uint64_t key_;
  double leaf_m_ = 0.0;
  Skeleton skeleton_{};
};

}  // namespace

double leaf_light(const LeafLight& light,
                  const Crown& crown,
                  double sun_azimuth_deg,
                  Point at,
                  std::uint32_t order) {
  const double away = std::hypot(at.x, at.y);
  const double outer = std::clamp(away / crown.radius_m(at.x, at.y), 0.0, 1.0);
  const double height =
      std::clamp((at.z - crown.hcb_m()) / (crown.h_m() - crown.hcb_m()), 0.0, 1.0);
  const double towards_sun = std::cos(std::atan2(at.x, at.y) - sun_azimuth_deg * kRadian);
  const double sun = 0.5 + 0.5 * outer * towards_sun;
  return light.outer * outer + light.height * height + light.sun * sun +
         light.order * (order >= 2 ? 1.0 : 0.0);
}

Skeleton BambooBuilder::grow_skeleton(const TreeShape& shape,
                                      const Crown& crown,
                                      Random& random,
                                      const MeshOptions& /*mesh*/) const {
  return BambooGrower(shape, crown, preset_, random).grow();
}

}  // namespace silvafit::tree
