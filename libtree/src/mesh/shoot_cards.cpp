// SPDX-License-Identifier: MIT
#include "mesh/shoot_cards.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "mesh/boughs.hpp"
#include "mesh/crown_light.hpp"
#include "mesh/jitter.hpp"
#include "mesh/leaf_surface.hpp"
#include "mesh/shoot_sites.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

constexpr double kGoldenAngle = 137.507764 * kRadian;
/// A card: its base in the middle of its lower edge.
struct Card {
  Point base{};
  Point along{};           ///< to its tip, as long as the card
  Point across{};          ///< from its middle to its right edge
  bool is_inside = false;  ///< known to be inside the crown

  double area_m2() const { return 2.0 * length(along) * length(across); }
};

class CardWriter {
 public:
  /// \param tree  the tree's own shade and warmth
  CardWriter(const Skeleton& skeleton,
             const Crown& crown,
             const LeafyShoots& shoots,
             double variation,
             Jitter tree,
             PartBuilder& build)
      : crown_(crown),
        shoots_(shoots),
        variation_(variation),
        cross_cos_(std::cos(kRadian * shoots.cross_deg)),
        cross_sin_(std::sin(kRadian * shoots.cross_deg)),
        light_(crown),
        boughs_(skeleton, crown, shoots.groove),
        build_(build) {
    // Trees of one species differ: some are darker, some more yellow.
    constexpr double kOfTrees = 0.5;
    const double bright = 1.0 + kOfTrees * variation * tree.next();
    const double warm = kOfTrees * variation * tree.next();
    tree_color_ = {bright * (1.0 + warm), bright, bright * (1.0 - warm)};
  }

  /// The shoots of a site from here on: drawn, or only measured.
  void draw(bool is_drawn) { is_drawn_ = is_drawn; }

  /// \param number  of the shoot, which gives its side of the branch
  /// \returns the area of its cards [m2]
  double add(const OnAxis& place,
             double end,
             const ShootSite& site,
             double size_m,
             std::uint32_t number,
             Jitter& jitter) {
    const Point outward = light_.outward(place.at);
    const Point along = site.free ? place.along : direction_of(place, end, outward, number, jitter);
    const double size = size_m * (1.0 + 0.15 * jitter.next());
    Point base = moved_inside(place.at, along, size, 0.75 * size);
    if (!crown_.contains(base)) base = crown_.confine(base);
    return crossed_cards(place.at,
                         base,
                         along,
                         size,
                         outward,
                         number,
                         jitter,
                         site.free                    ? At::kBeside
                         : end > 0.5 && !site.is_twig ? At::kEnd
                                                      : At::kBranch);
  }

  /// The shoot at the very end of a branch, which covers its tip.
  double add_tip(const OnAxis& place, double size_m, std::uint32_t number, Jitter& jitter) {
    const Point outward = light_.outward(place.at);
    Point along = direction_of(place, 1.0, outward, number, jitter);
    if (place.at.z <= crown_.hc_m()) {
      // Such branches rise along the lower surface of the crown. A shoot that rises more than its
      // branch would start outside.
      constexpr double kFlatter = 0.5;
      const Point flat = direction({place.at.x, place.at.y, 0.0}, place.along);
      along = direction(place.along + kFlatter * flat, place.along);
    }
    const double size = size_m * (1.0 + 0.15 * jitter.next());
    Point base = moved_inside(place.at, along, size, size);
    if (!crown_.contains(base)) base = crown_.confine(base);
    return crossed_cards(place.at, base, along, size, outward, number, jitter, At::kTip);
  }

  /// A whole twig, which stays at its branch and is shorter if it would reach out of the crown.
  double add_twig(Point base, Point chord, double size_m, std::uint32_t number, Jitter& jitter) {
    const Point along = direction(direction(chord) + Point{0.0, 0.0, shoots_.lift});
    const double room = crown_.length_inside_m(base, along, size_m);
    if (!(room > 0.0)) return 0.0;
    return crossed_cards(base, base, along, room, light_.outward(base), number, jitter, At::kEnd);
  }

 private:
  /// Where a shoot is on its branch. Those at its end must cover it and are not moved; those beside
  /// it, in a gap of the crown, are not needed where they have no room.
  enum class At { kBranch, kEnd, kTip, kBeside };

  /// A shoot that would reach out of the crown starts farther inside.
  Point moved_inside(Point base, Point along, double size_m, double farthest_m) const {
    const double room = crown_.length_inside_m(base, along, size_m);
    return base - std::min(size_m - room, farthest_m) * along;
  }

  /// Shoots of a flat spray are at its sides and lie in its plane, those of others all round.
  double roundness() const { return shoots_.cross_deg < 75.0 ? 0.35 : 1.0; }

  /// The shoot at the end of a branch continues it, others turn off to all sides.
  Point direction_of(
      const OnAxis& place, double end, Point outward, std::uint32_t number, Jitter& jitter) const {
    const double angle = kRadian * shoots_.angle_deg * (1.0 - end) * (1.0 + 0.3 * jitter.next());
    const Point aside = direction(cross(place.along, {0.0, 0.0, 1.0}), {1.0, 0.0, 0.0});
    const double azimuth = kGoldenAngle * number + 0.4 * jitter.next();
    const Point across =
        std::cos(azimuth) * aside + roundness() * std::sin(azimuth) * cross(aside, place.along);
    const double strayed = roundness() * (0.3 - 0.2 * end);
    const Point stray = strayed * Point{jitter.next(), jitter.next(), jitter.next()};
    return direction(std::cos(angle) * place.along + std::sin(angle) * across + 0.25 * outward +
                         stray + Point{0.0, 0.0, shoots_.lift},
                     place.along);
  }

  /// The first card faces up, or outward where the shoot is steep.
  Point upper_side(Point along, Point outward, Jitter& jitter) const {
    const Point wanted = Point{0.0, 0.0, 1.0} + 0.5 * outward +
                         0.35 * roundness() * Point{jitter.next(), jitter.next(), jitter.next()};
    const Point up = wanted - dot(wanted, along) * along;
    return direction(up, direction(cross(along, {0.6, -0.48, 0.64})));
  }

  /// Two cards, each smaller if the crown has no room for it.
  /// \param branch  where the shoot is on its branch
  double crossed_cards(Point branch,
                       Point base,
                       Point along,
                       double size_m,
                       Point outward,
                       std::uint32_t number,
                       Jitter& jitter,
                       At at) {
    const Point up = upper_side(along, outward, jitter);
    const Point side = cross(along, up);
    const Point crossed = cross_cos_ * side + cross_sin_ * up;
    const std::size_t picture = (number * 2654435761U >> 13U) % kShootsPerAtlas;
    const double shade = 1.0 + variation_ * jitter.next();
    const Bytes4 color = shaded(base + 0.5 * size_m * along, shade);
    const Point moved = at == At::kBranch || at == At::kBeside
                            ? with_room(base, size_m, {along, side, crossed}, outward)
                            : base;
    const auto cards_at = [&](Point start) {
      const auto card_of = [&](Point across) {
        const Card whole{start, size_m * along, 0.5 * size_m * across};
        return at == At::kTip ? fitted_to_tip(whole) : fitted(whole, share_at(whole, branch));
      };
      return std::array<Card, 2>{card_of(side), card_of(crossed)};
    };
    std::array<Card, 2> cards = cards_at(moved);
    const bool is_attached = std::any_of(
        cards.begin(), cards.end(), [&](const Card& card) { return reaches(card, branch); });
    // Where the crown has hardly any room, a shoot would float beside its branch.
    if (at == At::kBranch && !is_attached) cards = cards_at(branch);
    double area_m2 = 0.0;
    for (const Card& one : cards) {
      if (at == At::kBeside && !fits(one)) continue;
      area_m2 += one.area_m2();
      if (is_drawn_) card(one, picture, outward, color);
    }
    return area_m2;
  }

  /// Where the middle line of a card is nearest to a point, as a proportion of its length.
  static double share_at(const Card& card, Point branch) {
    const double squared = dot(card.along, card.along);
    return std::clamp(dot(branch - card.base, card.along) / squared, 0.0, 1.0);
  }

  /// Whether the middle line of a card passes near a point.
  static bool reaches(const Card& card, Point branch) {
    constexpr double kNear = 0.45;
    const Point apart = card.base + share_at(card, branch) * card.along - branch;
    return dot(apart, apart) < kNear * kNear * dot(card.along, card.along);
  }

  /// The base, or a place deeper in the crown at which both cards keep their size. Without this,
  /// slender crowns would lose half of their leaves.
  /// \param axes  the direction of the shoot, and those across its two cards
  Point with_room(Point base,
                  double size_m,
                  const std::array<Point, 3>& axes,
                  Point outward) const {
    for (const double depth : {0.0, 0.2, 0.4}) {
      const Point moved = base - depth * size_m * outward;
      const Point along = size_m * axes[0];
      if (fits({moved, along, 0.5 * size_m * axes[1]}) &&
          fits({moved, along, 0.5 * size_m * axes[2]})) {
        return moved;
      }
    }
    return base;
  }

  /// A card that is inside the crown, if three tenths of its size suffice for this. If it is enough
  /// it becomes only narrower, so that it covers the wood where the crown is thin.
  /// \param kept  the proportion of its length that stays where it is: on the branch
  Card fitted(const Card& whole, double kept) const {
    for (const double width : {1.0, 0.8, 0.65}) {
      const Card card{whole.base, whole.along, width * whole.across, true};
      if (fits(card)) return card;
    }
    // It has more room farther inside.
    constexpr double kInner = 0.35;
    const double fixed = std::max(kept - kInner, 0.0);
    const auto smaller = [&](double size) -> Card {
      const Point base = whole.base + (1.0 - size) * fixed * whole.along;
      return {base, size * whole.along, size * whole.across, false};
    };
    constexpr int kHalvings = 3;
    double inside = 0.3;
    double outside = 1.0;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (inside + outside);
      (fits(smaller(middle)) ? inside : outside) = middle;
    }
    return smaller(inside);
  }

  /// The same at the end of a branch: the card ends as near to the tip as possible, even if it is
  /// smaller for this.
  Card fitted_to_tip(const Card& whole) const {
    if (fits(whole)) return {whole.base, whole.along, whole.across, true};
    for (const double end : {1.0, 0.96, 0.88, 0.75}) {
      for (const double size : {1.0, 0.7}) {
        const Point base = whole.base + (1.0 - size) * end * whole.along;
        for (const double width : {1.0, 0.65, 0.45}) {
          const double part = size * end;
          const Card card{base, part * whole.along, part * width * whole.across, true};
          if (fits(card)) return card;
        }
      }
    }
    return fitted(whole, 1.0);
  }

  bool fits(const Card& card) const {
    return crown_.contains(card.base + card.along + card.across) &&
           crown_.contains(card.base + card.along - card.across) &&
           crown_.contains(card.base + card.across) && crown_.contains(card.base - card.across);
  }

  void card(const Card& card, std::size_t picture, Point outward, Bytes4 color) {
    const double width = length(card.across);
    const Point face = direction(cross(card.across, card.along));
    const Point seen = dot(face, outward + CrownLight::kAbove) >= 0.0 ? face : -1.0 * face;
    const double left = 0.5 * static_cast<double>(picture % 2);
    const std::size_t row = picture / 2;
    const double upper = 0.5 * static_cast<double>(row);
    std::array<LeafCorner, 6> corners{};
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double across = i % 2 == 0 ? -1.0 : 1.0;
      const double along = 0.5 * static_cast<double>(i / 2);
      // A shoot arches: its middle is above the line from its base to its tip.
      constexpr double kArch = 0.09;
      const Point arch = i / 2 == 1 ? (kArch * length(card.along)) * seen : Point{};
      const Point corner = card.base + along * card.along + across * card.across + arch;
      const bool is_inside = card.is_inside && i / 2 != 1;
      const Point at = is_inside ? corner : crown_.confine(corner);
      // Mostly that of the surface of crown and bough, less that of the card, and bulging to its
      // edges.
      constexpr double kOfCard = 0.5;
      constexpr double kBulge = 0.35;
      const Point bulge = (kBulge * across / width) * card.across;
      const Point normal = direction(
          light_.outward(at) + boughs_.outward(at) + CrownLight::kAbove + kOfCard * seen + bulge,
          seen);
      corners[i] = {at, normal, build_.vertex(at, normal)};
      const Point tangent =
          direction(card.across - dot(card.across, normal) * normal, {1.0, 0.0, 0.0});
      const float sign = dot(cross(normal, tangent), card.along) >= 0.0 ? 1.0F : -1.0F;
      build_.texture({.u = left + 0.25 * (1.0 + across),
                      .v = upper + 0.5 * (1.0 - along),
                      .tangent = tangent,
                      .sign = sign});
      build_.color(color);
    }
    for (const std::size_t low : {0U, 2U}) {
      add_leaf_triangle(corners[low], corners[low + 1], corners[low + 3], build_);
      add_leaf_triangle(corners[low], corners[low + 3], corners[low + 2], build_);
    }
  }

  /// Ambient occlusion: leaves deep in the crown get less light from the sky.
  Bytes4 shaded(Point at, double shade) const {
    constexpr double kInside = 0.7;
    const double open = kInside + (1.0 - kInside) * light_.share(at);
    // In steps that compress well and are not visible.
    constexpr double kSteps = 10.0;
    const double level = std::round(kSteps * open * shade / (1.0 + variation_)) / kSteps;
    const auto channel = [&](std::size_t k) { return to_byte(level * tree_color_[k]); };
    return {channel(0), channel(1), channel(2), 255};
  }

  const Crown& crown_;
  const LeafyShoots& shoots_;
  double variation_;
  double cross_cos_;  ///< of the angle between the two cards
  double cross_sin_;
  Color tree_color_{};  ///< relative to the species'
  CrownLight light_;
  Boughs boughs_;
  PartBuilder& build_;
  bool is_drawn_ = true;
};

/// The shoot of a site, at the level's size or at that of level 0.
class SiteDresser {
 public:
  SiteDresser(const Skeleton& skeleton,
              const Crown& crown,
              const WoodShift& shift,
              double size_m,
              CardWriter& writer)
      : skeleton_(skeleton), crown_(crown), shift_(shift), size_m_(size_m), writer_(writer) {}

  /// \param larger  relative to the shoots of level 0
  /// \returns the area of its cards [m2]
  double dress(const ShootSite& site, std::uint32_t number, double larger, Jitter jitter) {
    const auto axis = skeleton_.points_of(skeleton_.axes[site.axis]);
    OnAxis place = site.free ? *site.free : on_axis(axis, site.along_m);
    if (shift_) place.at = place.at + shift_(site.axis, place.at);
    place.at = crown_.confine(place.at);
    if (site.twig_m > 0.0) {
      const Point chord = axis.back().at - axis.front().at;
      return writer_.add_twig(place.at, chord, larger * site.twig_m, number, jitter);
    }
    const double size_m = larger * size_m_;
    if (site.is_tip) return writer_.add_tip(place, size_m, number, jitter);
    // The last shoots of a branch continue it.
    const double end = std::clamp(1.0 - site.rest_m / (0.6 * size_m), 0.0, 1.0);
    return writer_.add(place, end, site, size_m, number, jitter);
  }

 private:
  const Skeleton& skeleton_;
  const Crown& crown_;
  const WoodShift& shift_;
  double size_m_;  ///< of level 0
  CardWriter& writer_;
};

}  // namespace

void dress_shoots(const LeafyShoots& shoots,
                  const Bark& bark,
                  const Color& leaf,
                  double variation,
                  const MeshOptions& options,
                  MeshPart& part) {
  const bool has_leaves = shoots.has_leaves(options.season);
  const ShootAtlas& atlas = has_leaves ? shoots.picture->leafy() : shoots.picture->bare();
  part.texture = atlas.color;
  part.normal_texture = atlas.normals;
  part.color = leaf;
  // The thinnest wood.
  if (!has_leaves) part.color = bark.shades.empty() ? bark.color : bark.shades.front().color;
  for (double& channel : part.color) channel = std::min(1.0, channel * (1.0 + variation));
}

void add_shoots(const Skeleton& skeleton,
                const Crown& crown,
                const LeafyShoots& shoots,
                double variation,
                Random& random,
                const MeshOptions& options,
                const WoodShift& shift,
                PartBuilder& build) {
  const Jitter tree(random);
  const auto [size_m, sites] = shoot_sites(skeleton, crown, shoots, random, options);
  const auto per = static_cast<std::uint32_t>(options.foliage_per);
  const double larger = std::sqrt(static_cast<double>(per));
  CardWriter writer(skeleton, crown, shoots, variation, tree, build);
  SiteDresser sites_of(skeleton, crown, shift, size_m, writer);
  // Larger shoots have less room in the crown: what they lose, the shoots of other sites cover.
  double owed_m2 = 0.0;
  for (std::uint32_t i = 0; i < sites.size(); ++i) {
    const Jitter jitter(random);
    if (per > 1) {
      writer.draw(false);
      owed_m2 += sites_of.dress(sites[i], i, 1.0, jitter);
      writer.draw(true);
    }
    // A pair of cards that keep their size.
    const double whole_m2 = 2.0 * per * size_m * size_m;
    if (i % per == 0 || owed_m2 > 0.5 * whole_m2) {
      build.reserve(12, 8);
      owed_m2 -= sites_of.dress(sites[i], i, larger, jitter);
    }
  }
}

}  // namespace silvafit::tree
