// SPDX-License-Identifier: MIT
// Pictures of leafy shoots, drawn from seeds.
#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <utility>

#include "pictures/shoot_canvas.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/tree/texture_library.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kShootSide = 512;
constexpr double kMeanLight = 0.8;

/// The five lobes of an Acer platanoides leaf, one half.
constexpr std::array<std::array<double, 2>, 12> kMaple{{{0.1, 0.02},
                                                        {0.45, -0.04},
                                                        {0.62, 0.08},
                                                        {0.5, 0.17},
                                                        {0.8, 0.27},
                                                        {1.0, 0.5},
                                                        {0.72, 0.47},
                                                        {0.62, 0.56},
                                                        {0.38, 0.5},
                                                        {0.46, 0.72},
                                                        {0.3, 0.74},
                                                        {0.2, 0.86}}};

/// How the leaves of a shoot are arranged. Lengths are relative to the picture.
struct ShootPlan {
  Blade blade{};
  double leaf_length = 0.17;
  double leaf_aspect = 0.45;
  double spacing = 0.05;     ///< between leaves, or between pairs
  bool is_opposite = false;  ///< pairs instead of alternating leaves
  double angle_deg = 55.0;   ///< between leaf and twig at its base; half of that at the tip
  double angle_sd_deg = 9.0;
  double bare = 0.12;  ///< proportion of a twig without leaves
  int side_twigs = 8;
  double side_length = 0.5;
  double side_angle_deg = 47.0;
  double droop = 0.0;  ///< how far side twigs and leaves turn down, radians a length
  double twig_width = 0.011;
  double shade_sd = 0.11;
  double warmth_sd = 0.16;
  double shadow = 0.3;
  Tint twig{0.85, 0.5, 0.75};
};

ShootPlan plan_of(ShootKind kind) {
  ShootPlan plan;
  switch (kind) {
    case ShootKind::kAlternate:
      break;
    case ShootKind::kOpposite:
      plan.is_opposite = true;
      plan.leaf_length = 0.15;
      plan.leaf_aspect = 0.42;
      plan.spacing = 0.085;
      plan.angle_deg = 58.0;
      break;
    case ShootKind::kLobed:
      plan.blade.outline = kMaple;
      plan.blade.veins = 4.0;
      plan.is_opposite = true;
      plan.leaf_length = 0.2;
      plan.leaf_aspect = 1.05;
      plan.spacing = 0.14;
      plan.angle_deg = 62.0;
      plan.side_twigs = 5;
      break;
    case ShootKind::kCrowded:
      plan.blade.rise = 1.0;
      plan.blade.fall = 0.6;
      plan.leaf_length = 0.24;
      plan.leaf_aspect = 0.27;
      plan.spacing = 0.028;
      plan.angle_deg = 75.0;
      plan.bare = 0.5;
      plan.side_twigs = 9;
      plan.side_length = 0.46;
      break;
    case ShootKind::kFlatNeedles:
      // Two ranks of linear leaves that taper to a sharp tip from near the base.
      plan.blade.rise = 0.25;
      plan.blade.fall = 0.7;
      plan.blade.veins = 0.0;
      plan.leaf_length = 0.083;
      plan.leaf_aspect = 0.115;
      plan.spacing = 0.013;
      plan.is_opposite = true;
      plan.angle_deg = 68.0;
      plan.angle_sd_deg = 5.0;
      plan.bare = 0.04;
      plan.side_twigs = 10;
      plan.side_length = 0.5;
      plan.side_angle_deg = 48.0;
      plan.shadow = 0.22;
      plan.shade_sd = 0.14;
      plan.twig = {0.8, 0.75, 0.7};
      break;
    case ShootKind::kNeedles:
      plan.blade.rise = 0.2;
      plan.blade.fall = 0.4;
      plan.blade.veins = 0.0;
      plan.leaf_length = 0.055;
      plan.leaf_aspect = 0.17;
      plan.spacing = 0.0085;
      plan.is_opposite = true;
      plan.angle_deg = 52.0;
      plan.angle_sd_deg = 10.0;
      plan.bare = 0.0;
      plan.side_twigs = 16;
      plan.side_length = 0.52;
      plan.side_angle_deg = 50.0;
      plan.droop = 0.5;
      plan.shadow = 0.2;
      plan.shade_sd = 0.16;
      plan.twig = {0.9, 0.55, 0.7};
      break;
    case ShootKind::kFrond:
      plan.blade.rise = 0.35;
      plan.blade.fall = 0.7;
      plan.blade.veins = 0.0;
      plan.leaf_length = 0.075;
      plan.leaf_aspect = 0.3;
      plan.spacing = 0.021;
      plan.is_opposite = true;
      plan.angle_deg = 72.0;
      plan.bare = 0.05;
      plan.side_twigs = 14;
      plan.side_length = 0.46;
      plan.side_angle_deg = 68.0;
      plan.shadow = 0.2;
      plan.twig = {0.8, 0.7, 0.6};
      break;
  }
  return plan;
}

/// Draws one shoot: its twigs first, then its leaves from the base to the tip.
class ShootDrawing {
 public:
  ShootDrawing(const ShootPlan& plan, std::uint64_t seed)
      : plan_(plan), random_(seed, 0x5b00), canvas_(kShootSide) {}

  ShootCanvas draw() {
    const double lean = random_.uniform(-0.06, 0.06);
    add_twig({0.5, 0.01}, lean, 0.8, plan_.twig_width);
    const Twig main = twigs_.front();
    for (int i = 0; i < plan_.side_twigs; ++i) {
      const double share = 0.08 + 0.72 * (i + random_.uniform(0.2, 0.8)) / plan_.side_twigs;
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      const double angle =
          lean + side * kRadian * (plan_.side_angle_deg + random_.normal(0.0, 5.0));
      const double length = plan_.side_length * (1.0 - 0.55 * share) * random_.uniform(0.85, 1.1);
      add_twig(main.at(share), angle, length, 0.6 * plan_.twig_width);
    }
    for (const Twig& twig : twigs_) {
      canvas_.twig(twig.from, twig.at(0.5), twig.width, 0.75 * twig.width, plan_.twig);
      canvas_.twig(twig.at(0.5), twig.at(1.0), 0.75 * twig.width, 0.4 * twig.width, plan_.twig);
    }
    // The main twig is on top.
    for (std::size_t i = twigs_.size(); i-- > 0;) add_leaves(twigs_[i]);
    return std::move(canvas_);
  }

 private:
  struct Twig {
    Spot from{};
    double angle_rad = 0.0;
    double length = 0.0;
    double width = 0.0;
    double bend = 0.0;  ///< further turn at the tip

    Spot at(double share) const {
      const double turn = angle_rad + 0.5 * bend * share;
      return from + share * length * towards(turn);
    }
    double direction(double share) const { return angle_rad + bend * share; }
  };

  void add_twig(Spot from, double angle_rad, double length, double width) {
    Twig twig{.from = from, .angle_rad = angle_rad, .length = length, .width = width};
    twig.bend = random_.normal(0.0, 0.12) + plan_.droop * angle_rad * length;
    twigs_.push_back(twig);
  }

  void add_leaves(const Twig& twig) {
    const double leafy = (1.0 - plan_.bare) * twig.length;
    const int number = std::max(2, static_cast<int>(leafy / plan_.spacing));
    for (int i = 0; i < number; ++i) {
      const double share = plan_.bare + (1.0 - plan_.bare) * (i + 0.5) / number;
      for (const double side : {1.0, -1.0}) {
        if (!plan_.is_opposite && (i % 2 == 0) != (side > 0.0)) continue;
        add_leaf(twig, share, side);
      }
    }
    add_leaf(twig, 1.0, 0.0);
  }

  void add_leaf(const Twig& twig, double share, double side) {
    const double angle = kRadian * (plan_.angle_deg * (1.0 - 0.5 * share * share) +
                                    random_.normal(0.0, plan_.angle_sd_deg));
    // Leaves near both ends of a twig are shorter.
    const double size = (0.72 + 0.28 * std::sin(std::numbers::pi * std::min(share + 0.15, 1.0))) *
                        random_.uniform(0.85, 1.1);
    const double direction = twig.direction(share) + side * angle;
    DrawnLeaf leaf{.base = twig.at(share),
                   .angle_rad = direction + plan_.droop * 0.3 * std::sin(direction),
                   .length = plan_.leaf_length * size,
                   .bend = random_.normal(0.0, 0.05),
                   .shade = std::max(0.5, 1.0 + random_.normal(0.0, plan_.shade_sd)),
                   .warmth = random_.normal(0.0, plan_.warmth_sd),
                   .tilt_x = random_.normal(0.0, 0.5),
                   .tilt_y = random_.normal(0.0, 0.5)};
    leaf.width = plan_.leaf_aspect * leaf.length * random_.uniform(0.85, 1.1);
    // Young leaves at the tip are lighter.
    leaf.shade *= 0.92 + 0.16 * share;
    leaf.warmth += 0.15 * share;
    canvas_.leaf(leaf, plan_.blade, plan_.shadow);
  }

  const ShootPlan& plan_;
  Random random_;
  ShootCanvas canvas_;
  std::vector<Twig> twigs_{};
};

const char* name_of(ShootKind kind) {
  switch (kind) {
    case ShootKind::kAlternate:
      return "shoots-alternate";
    case ShootKind::kOpposite:
      return "shoots-opposite";
    case ShootKind::kLobed:
      return "shoots-lobed";
    case ShootKind::kCrowded:
      return "shoots-crowded";
    case ShootKind::kFlatNeedles:
      return "shoots-flat-needles";
    case ShootKind::kNeedles:
      return "shoots-needles";
    case ShootKind::kFrond:
      return "shoots-frond";
  }
  return "";
}

ShootAtlas drawn(ShootKind kind) {
  const ShootPlan plan = plan_of(kind);
  std::vector<ShootCanvas> shoots;
  double light = 0.0;
  double area = 0.0;
  double leaf_area = 0.0;
  for (std::uint64_t i = 0; i < kShootsPerAtlas; ++i) {
    shoots.push_back(ShootDrawing(plan, 16 * static_cast<std::uint64_t>(kind) + i + 1).draw());
    light += shoots.back().brightness();
    area += shoots.back().covered();
    leaf_area += shoots.back().leaf_area();
  }
  Texture color{
      .name = name_of(kind), .width = 2 * kShootSide, .height = 2 * kShootSide, .pictures = 2};
  color.rgba.resize(4 * color.width * color.height);
  Texture normals = color;
  normals.name += "-normal";
  for (std::size_t i = 0; i < shoots.size(); ++i) {
    shoots[i].copy_to(
        color, normals, i % 2 * kShootSide, i / 2 * kShootSide, kMeanLight * area / light);
  }
  return {.color = std::make_shared<const Texture>(std::move(color)),
          .normals = std::make_shared<const Texture>(std::move(normals)),
          .covered = leaf_area / static_cast<double>(kShootsPerAtlas * kShootSide * kShootSide)};
}

}  // namespace

const std::vector<std::pair<const char*, ShootKind>>& shoot_kinds() {
  static const std::vector<std::pair<const char*, ShootKind>> kinds{
      {"alternate", ShootKind::kAlternate},
      {"opposite", ShootKind::kOpposite},
      {"lobed", ShootKind::kLobed},
      {"crowded", ShootKind::kCrowded},
      {"flat-needles", ShootKind::kFlatNeedles},
      {"needles", ShootKind::kNeedles},
      {"frond", ShootKind::kFrond}};
  return kinds;
}

const ShootAtlas& shoot_atlas(ShootKind kind) {
  static std::array<std::once_flag, 7> once;
  static std::array<ShootAtlas, 7> atlases;
  const auto at = static_cast<std::size_t>(kind);
  std::call_once(once.at(at), [&] { atlases.at(at) = drawn(kind); });
  return atlases.at(at);
}

}  // namespace silvafit::tree
