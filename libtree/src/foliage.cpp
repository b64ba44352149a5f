// SPDX-License-Identifier: MIT
#include "foliage.hpp"

#include <algorithm>
#include <cmath>

#include "part_builder.hpp"

namespace silvafit::tree {
namespace {

constexpr int kLeavesOnTips = 2;

/// A card of two triangles folded along its middle: base, left, tip, right.
class CardBuilder {
 public:
  CardBuilder(const Crown& crown, const Foliage& foliage, MeshPart& part)
      : crown_(crown), foliage_(foliage), build_(part) {
    const double length = crown.h_m() - crown.hcb_m();
    center_ = {0.0, 0.0, crown.hcb_m() + 0.35 * length};
    across_ = 2.0 / crown.radii().width_m();
    along_ = 2.0 / length;
  }

  struct Card {
    Point base{};
    Point tip{};
    Point side{};         ///< from the middle to the right corner
    Point droop{};        ///< of both outer corners
    double widest = 0.5;  ///< share of the length at which the outer corners stand
    double shade = 1.0;   ///< factor on the color
  };

  void reserve(std::size_t cards) { build_.reserve(4 * cards, 2 * cards, true); }

  void add(const Card& card) {
    // A card that would reach out is moved in whole; cutting it off would leave a clipped hedge.
    const Point tip = crown_.confine(card.tip);
    const Point base = crown_.confine(card.base + (tip - card.tip));
    const Point middle = base + card.widest * (tip - base) + card.droop;
    Point right = crown_.confine(middle + card.side);
    Point left = crown_.confine(middle - card.side);
    Point face = direction(cross(right - base, tip - base));
    const Point outward = outward_of(card.tip);
    // Counter-clockwise as seen from outside the crown, where light and viewers are.
    if (dot(face, outward) < 0.0) {
      std::swap(left, right);
      face = -1.0 * face;
    }
    // Cards lit by the crown's own shape read as foliage; lit one by one they flicker.
    const Point normal = direction(0.8 * face + outward);
    const Bytes4 inner = color_at(base, card.shade);
    const Bytes4 outer = color_at(tip, card.shade);
    const auto a = build_.vertex(base, normal, inner);
    const auto b = build_.vertex(right, normal, outer);
    const auto c = build_.vertex(tip, normal, outer);
    const auto d = build_.vertex(left, normal, outer);
    build_.triangle(a, b, c);
    build_.triangle(a, c, d);
  }

  /// Away from the crown's inside, as on an ellipsoid with the crown's width and length.
  Point outward_of(Point at) const {
    const Point from = at - center_;
    return direction({from.x * across_, from.y * across_, from.z * along_});
  }

 private:
  Bytes4 color_at(Point at, double shade) const {
    const Point from = at - center_;
    const double reach = std::sqrt(across_ * across_ * (from.x * from.x + from.y * from.y) +
                                   along_ * along_ * from.z * from.z);
    const double light = std::clamp(reach, 0.0, 1.0);
    const double mix = light * light;
    Bytes4 color{0, 0, 0, 255};
    for (std::size_t i = 0; i < 3; ++i) {
      // The material holds the outer color; vertices hold their share of it.
      const double value = foliage_.inner[i] + mix * (foliage_.outer[i] - foliage_.inner[i]);
      color[i] = to_byte(shade * value / foliage_.outer[i]);
    }
    return color;
  }

  const Crown& crown_;
  const Foliage& foliage_;
  PartBuilder build_;
  Point center_{};
  double across_ = 1.0;
  double along_ = 1.0;
};

class FoliageGrower {
 public:
  FoliageGrower(const Skeleton& skeleton,
                const Crown& crown,
                const Foliage& foliage,
                Random& random,
                MeshPart& part)
      : skeleton_(skeleton),
        crown_(crown),
        foliage_(foliage),
        random_(random),
        cards_(crown, foliage, part) {
    // Cards stand for sprays of leaves: in a larger crown, each stands for more of them.
    constexpr double kReferenceWidth = 5.0;
    constexpr double kReferenceLength = 7.0;
    leaf_length_m_ =
        foliage.leaf_length_m * std::sqrt(crown.radii().width_m() * (crown.h_m() - crown.hcb_m()) /
                                          (kReferenceWidth * kReferenceLength));
  }

  void grow() {
    cards_.reserve(number_of_cards());
    for (const Axis& axis : skeleton_.axes) {
      if (axis.order == 0) continue;
      const auto points = skeleton_.points_of(axis);
      if (foliage_.kind == FoliageKind::kNeedles) {
        add_needles(axis.order == 1 ? points[points.size() - 2].at : points.front().at,
                    points.back().at);
      } else {
        add_leaves(points, axis.order == 1 ? kLeavesOnTips : foliage_.leaves_per_twig);
      }
    }
  }

 private:
  std::size_t number_of_cards() const {
    const auto branches = std::count_if(skeleton_.axes.begin(),
                                        skeleton_.axes.end(),
                                        [](const Axis& axis) { return axis.order == 1; });
    const auto twigs = static_cast<std::ptrdiff_t>(skeleton_.axes.size()) - 1 - branches;
    return static_cast<std::size_t>(foliage_.kind == FoliageKind::kNeedles
                                        ? branches + twigs
                                        : kLeavesOnTips * branches +
                                              foliage_.leaves_per_twig * twigs);
  }

  double draw_shade() {
    return 1.0 + random_.uniform(-foliage_.color_variation, foliage_.color_variation);
  }

  /// A flat spray along a twig that hangs a little on both sides.
  void add_needles(Point base, Point tip) {
    const Point along = tip - base;
    const double size = length(along);
    if (size <= 0.0) return;
    const Point side = direction(cross(along, {0.0, 0.0, 1.0}), {1.0, 0.0, 0.0});
    const Point down = (-1.0 / size) * cross(side, along);
    const double half_width = 0.5 * foliage_.width * size;
    const double shade = draw_shade();
    cards_.add({.base = base,
                .tip = tip,
                .side = half_width * side,
                .droop = foliage_.droop * half_width * down,
                .widest = 0.4,
                .shade = shade});
  }

  void add_leaves(std::span<const SkeletonPoint> points, int number) {
    const Point base = points[points.size() - 2].at;
    const Point along = points.back().at - base;
    for (int i = 0; i < number; ++i) {
      const double share = 0.3 + 0.7 * (i + 1.0) / number;
      const Point stray = random_direction();
      const Point root = crown_.confine(base + share * along + 0.5 * leaf_length_m_ * stray);
      const Point outward = cards_.outward_of(root);
      const double size = leaf_length_m_ * random_.uniform(0.7, 1.15);
      const Point turned = random_direction();
      const Point axis = direction(turned + 0.5 * outward);
      // A card lies rather in the crown's surface than across it.
      const Point side = direction(cross(axis, outward + 0.5 * stray), {1.0, 0.0, 0.0});
      cards_.add({.base = root,
                  .tip = root + size * axis,
                  .side = 0.5 * foliage_.leaf_aspect * size * side,
                  .droop = -0.12 * size * outward,
                  .widest = 0.5,
                  .shade = draw_shade()});
    }
  }

  /// A direction; it need not be perfectly even over the sphere here.
  Point random_direction() {
    const double x = random_.uniform(-1.0, 1.0);
    const double y = random_.uniform(-1.0, 1.0);
    const double z = random_.uniform(-1.0, 1.0);
    return direction({x, y, z});
  }

  const Skeleton& skeleton_;
  const Crown& crown_;
  const Foliage& foliage_;
  Random& random_;
  CardBuilder cards_;
  double leaf_length_m_ = 0.0;
};

}  // namespace

void add_foliage(const Skeleton& skeleton,
                 const Crown& crown,
                 const Foliage& foliage,
                 Random& random,
                 MeshPart& part) {
  FoliageGrower(skeleton, crown, foliage, random, part).grow();
}

}  // namespace silvafit::tree
