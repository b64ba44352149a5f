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

/// Draws one shoot: its twigs first, then its leaves from the base to the tip.
class ShootDrawing {
 public:
  ShootDrawing(const ShootPlan& plan, std::uint64_t seed)
      : plan_(plan), random_(seed, 0x5b00), canvas_(kShootSide) {}

  ShootCanvas draw(bool has_leaves) {
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
    if (!has_leaves) return std::move(canvas_);
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
      // Of a whorl, leaves that point at the viewer look short.
      for (int k = 0; k < plan_.whorl; ++k) {
        add_leaf(twig, share, std::cos(random_.uniform(0.0, std::numbers::pi)));
      }
      for (const double side : {1.0, -1.0}) {
        if (plan_.whorl > 0 || (!plan_.is_opposite && (i % 2 == 0) != (side > 0.0))) continue;
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
    // Side is the share of the angle's sine that is seen.
    const double seen = std::hypot(std::cos(angle), side * std::sin(angle));
    const double direction =
        twig.direction(share) + std::atan2(side * std::sin(angle), std::cos(angle));
    PictureLeaf leaf{.base = twig.at(share),
                     .angle_rad = direction + plan_.droop * 0.3 * std::sin(direction),
                     .length = plan_.leaf_length * size * std::max(seen, 0.2),
                     .bend = random_.normal(0.0, plan_.bend),
                     .shade = std::max(0.5, 1.0 + random_.normal(0.0, plan_.shade_sd)),
                     .warmth = random_.normal(0.0, plan_.warmth_sd),
                     .tilt_x = random_.normal(0.0, 0.5),
                     .tilt_y = random_.normal(0.0, 0.5)};
    leaf.width = plan_.leaf_aspect * plan_.leaf_length * size * random_.uniform(0.85, 1.1);
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

ShootAtlas drawn(const ShootPlan& plan, bool has_leaves) {
  std::vector<ShootCanvas> shoots;
  double light = 0.0;
  double area = 0.0;
  double leaf_area = 0.0;
  for (std::uint64_t i = 0; i < kShootsPerAtlas; ++i) {
    const std::uint64_t seed = kShootsPerAtlas * kShootsPerAtlas * plan.seed + i + 1;
    shoots.push_back(ShootDrawing(plan, seed).draw(has_leaves));
    light += shoots.back().brightness();
    area += shoots.back().covered();
    leaf_area += shoots.back().leaf_area();
  }
  Texture color{.name = (has_leaves ? "shoots-" : "twigs-") + plan.name,
                .width = 2 * kShootSide,
                .height = 2 * kShootSide,
                .pictures = 2};
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

const ShootAtlas& ShootPicture::leafy() const {
  std::call_once(once_[0], [this] { atlases_[0] = drawn(plan_, true); });
  return atlases_[0];
}

const ShootAtlas& ShootPicture::bare() const {
  std::call_once(once_[1], [this] { atlases_[1] = drawn(plan_, false); });
  return atlases_[1];
}

}  // namespace silvafit::tree
