// SPDX-License-Identifier: MIT
#include "mesh/shoot_cards.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "mesh/crown_light.hpp"
#include "mesh/jitter.hpp"
#include "mesh/leaf_corner.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

constexpr double kGoldenAngle = 137.507764 * kRadian;
// Two cards are four triangles; a tree should have no more than some ten thousand.
constexpr std::size_t kMostShoots = 1700;
constexpr double kFlat_m = 1e-6;

/// A part of an axis that bears shoots.
struct LeafyPart {
  std::uint32_t axis = 0;
  double from_m = 0.0;    ///< along the axis
  double length_m = 0.0;  ///< leafy
  double whole_m = 0.0;   ///< of the axis
  double end_m = 0.0;     ///< from the last branch that it bears to its tip, or all of it
  double weight = 1.0;    ///< shoots a meter, relative to the mean
};

double length_of(std::span<const SkeletonPoint> points) {
  double sum = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += length(points[i].at - points[i - 1].at);
  return sum;
}

/// Distance from the last branch on each axis to its tip; none: infinite.
std::vector<double> bare_ends_m(const Skeleton& skeleton) {
  std::vector<double> ends(skeleton.axes.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) {
    const std::uint32_t parent = skeleton.axes[i].parent;
    const Point tip = skeleton.points_of(skeleton.axes[parent]).back().at;
    ends[parent] = std::min(ends[parent], length(skeleton.points[skeleton.axes[i].first].at - tip));
  }
  return ends;
}

/// A point of an axis and the direction there.
struct OnAxis {
  Point at{};
  Point along{};
};

OnAxis on_axis(std::span<const SkeletonPoint> points, double along_m) {
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Point step = points[i].at - points[i - 1].at;
    const double size = length(step);
    if (along_m <= size || i + 1 == points.size()) {
      const double share = size > 0.0 ? std::clamp(along_m / size, 0.0, 1.0) : 0.0;
      return {points[i - 1].at + share * step, direction(step, {0.0, 0.0, 1.0})};
    }
    along_m -= size;
  }
  return {points.back().at, {0.0, 0.0, 1.0}};
}

/// The first place of an axis that is near the crown's surface: where the crown is at most twice as
/// wide as the axis is far from the stem. Relative to the axis' length, at steps of a tenth.
double from_surface(std::span<const SkeletonPoint> points, double whole_m, const Crown& crown) {
  constexpr int kSteps = 10;
  constexpr double kNear = 0.5;
  for (int i = 0; i < kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    const Point at = on_axis(points, share * whole_m).at;
    const double width_m = crown.radius_m(at.x, at.y) * crown.relative_width(at.z);
    if (std::hypot(at.x, at.y) >= kNear * width_m) return share;
  }
  return 1.0;
}

/// Branches that bear others have leaves only where they are not shaded: on their outer part, which
/// is the longer the higher they start, and along the surface of the crown.
std::vector<LeafyPart> leafy_parts(const Skeleton& skeleton, const Crown& crown) {
  const std::vector<double> ends = bare_ends_m(skeleton);
  // A drawing that is not fitted may have all its branches at one height.
  const double crown_m = std::max(crown.h_m() - crown.hcb_m(), kFlat_m);
  std::vector<LeafyPart> parts;
  parts.reserve(skeleton.axes.size());
  for (std::uint32_t i = 1; i < skeleton.axes.size(); ++i) {
    constexpr double kBareBearer = 0.6;
    constexpr double kBareTwig = 0.1;
    const auto points = skeleton.points_of(skeleton.axes[i]);
    const double whole = length_of(points);
    if (!(whole > 0.0)) continue;
    double from = kBareTwig;
    if (std::isfinite(ends[i])) {
      const double depth = std::clamp((crown.h_m() - points.front().at.z) / crown_m, 0.0, 1.0);
      from = std::min(kBareBearer * depth, from_surface(points, whole, crown));
    }
    parts.push_back({i, from * whole, (1.0 - from) * whole, whole, std::min(ends[i], whole)});
  }
  return parts;
}

/// Leaves are where the light is: the shoots of a part of the crown follow its surface there, and
/// not only the length of its branches, of which a skeleton may have few or many near its top or on
/// one side.
class SurfaceCells {
 public:
  explicit SurfaceCells(const Crown& crown)
      : crown_(crown), layer_m_((crown.h_m() - crown.hcb_m()) / kLayers) {}

  void follow(const Skeleton& skeleton, std::vector<LeafyPart>& parts) const {
    if (layer_m_ < kFlat_m) return;
    std::vector<std::size_t> cells(parts.size());
    std::array<double, kCells> leafy_m{};
    double sum_m = 0.0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Axis& axis = skeleton.axes[parts[i].axis];
      cells[i] = cell_of(skeleton.points[axis.first + axis.count / 2].at);
      leafy_m[cells[i]] += parts[i].length_m;
      sum_m += parts[i].length_m;
    }
    std::array<double, kCells> weights = surface_with(leafy_m);
    constexpr double kLeast = 0.4;
    constexpr double kMost = 2.5;
    for (std::size_t k = 0; k < kCells; ++k) {
      if (leafy_m[k] > 0.0) weights[k] = std::clamp(weights[k] * sum_m / leafy_m[k], kLeast, kMost);
    }
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i].weight = weights[cells[i]];
  }

 private:
  static constexpr std::size_t kLayers = 12;
  static constexpr std::size_t kSectors = 8;
  static constexpr std::size_t kCells = kLayers * kSectors;

  /// Proportion of the crown's surface in each cell. That of cells without branches counts for the
  /// others of their layer.
  std::array<double, kCells> surface_with(const std::array<double, kCells>& leafy_m) const {
    std::array<double, kCells> areas{};
    double sum = 0.0;
    for (std::size_t layer = 0; layer < kLayers; ++layer) {
      const double z = crown_.hcb_m() + (static_cast<double>(layer) + 0.5) * layer_m_;
      const double width = crown_.relative_width(z);
      double whole = 0.0;
      double leafy = 0.0;
      for (std::size_t sector = 0; sector < kSectors; ++sector) {
        const double azimuth = kTwoPi * (static_cast<double>(sector) + 0.5) / kSectors;
        const std::size_t k = layer * kSectors + sector;
        areas[k] = width * crown_.radius_m(std::cos(azimuth), std::sin(azimuth));
        whole += areas[k];
        if (leafy_m[k] > 0.0) leafy += areas[k];
      }
      if (!(leafy > 0.0)) continue;
      for (std::size_t k = layer * kSectors; k < (layer + 1) * kSectors; ++k) {
        areas[k] *= whole / leafy;
      }
      sum += whole;
    }
    for (double& area : areas) area /= sum;
    return areas;
  }

  std::size_t cell_of(Point at) const {
    const double turn = std::atan2(at.y, at.x) / kTwoPi + 1.0;
    const double layer = std::clamp((at.z - crown_.hcb_m()) / layer_m_, 0.0, kLayers - 1.0);
    const auto sector = static_cast<std::size_t>(turn * kSectors) % kSectors;
    return static_cast<std::size_t>(layer) * kSectors + sector;
  }

  const Crown& crown_;
  double layer_m_;
};

/// The position of a shoot.
struct ShootSite {
  std::uint32_t axis = 0;
  double along_m = 0.0;
  double rest_m = 0.0;  ///< up to the end of the axis
  double twig_m = 0.0;  ///< length of the twig that the shoot is, if it is a whole one
  bool is_tip = false;  ///< at the end of a branch that is drawn as wood
};

/// Length of the stem above its highest branch.
double bare_top_m(const Skeleton& skeleton) {
  double highest = 0.0;
  for (const Axis& axis : skeleton.axes) {
    if (axis.order == 1) highest = std::max(highest, skeleton.points[axis.first].at.z);
  }
  return skeleton.points_of(skeleton.axes.front()).back().at.z - highest;
}

/// The top of the stem, the ends of all branches that are drawn as wood, and what is bare before
/// these ends, so that all have leaves.
std::vector<ShootSite> sites_at_ends(const Skeleton& skeleton,
                                     const std::vector<LeafyPart>& parts,
                                     double size_m,
                                     const MeshOptions& options) {
  std::vector<ShootSite> sites;
  const double stem_m = length_of(skeleton.points_of(skeleton.axes.front()));
  constexpr double kApart = 0.35;
  constexpr int kMostOnTop = 16;
  const double bare_m = std::max(bare_top_m(skeleton), 0.7 * size_m);
  for (int i = 0; i < kMostOnTop && i * kApart * size_m <= bare_m; ++i) {
    const double back_m = i * kApart * size_m;
    sites.push_back({0, std::max(stem_m - back_m, 0.0), back_m});
  }
  const auto diameter_m = [&](const LeafyPart& part) {
    return 2.0 * skeleton.points[skeleton.axes[part.axis].first].radius_m;
  };
  const auto is_wood = [&](const LeafyPart& part) {
    return skeleton.axes[part.axis].order == 1 || diameter_m(part) >= options.thinnest_wood_m;
  };
  for (const LeafyPart& part : parts) {
    if (is_wood(part)) sites.push_back({part.axis, part.whole_m, 0.0, 0.0, true});
  }
  for (const LeafyPart& part : parts) {
    constexpr double kThick = 0.025;
    constexpr int kMostOnBranch = 8;
    const bool is_twig = part.end_m == part.whole_m && diameter_m(part) < kThick;
    if (is_twig || !is_wood(part)) continue;
    const double leafy_m = std::min(part.end_m, part.length_m);
    for (int i = 1; i <= kMostOnBranch && sites.size() < kMostShoots; ++i) {
      const double back_m = kApart * i * size_m;
      if (back_m > leafy_m) break;
      sites.push_back({part.axis, part.whole_m - back_m, back_m});
    }
  }
  return sites;
}

/// A twig without wood is drawn by its shoots only: they follow one another from its base, so that
/// none is separate from its branch.
ShootSite joined(const ShootSite& site, double size_m) {
  const double along_m = std::floor(site.along_m / size_m) * size_m;
  return {site.axis, along_m, 0.0};
}

/// All twigs, and the top of the stem.
std::vector<ShootSite> sites_of_whole_twigs(const Skeleton& skeleton,
                                            const std::vector<LeafyPart>& parts) {
  std::vector<ShootSite> sites;
  const double stem_m = length_of(skeleton.points_of(skeleton.axes.front()));
  std::vector<bool> bears(skeleton.axes.size(), false);
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) bears[skeleton.axes[i].parent] = true;
  for (const LeafyPart& part : parts) {
    if (!bears[part.axis]) sites.push_back({part.axis, 0.0, part.whole_m, part.whole_m});
  }
  sites.push_back({0, stem_m, 0.0});
  return sites;
}

/// A number of sites along all leafy parts, at distances by the parts' weights.
void add_sites_along(const Skeleton& skeleton,
                     const std::vector<LeafyPart>& parts,
                     int number,
                     double size_m,
                     Jitter& places,
                     std::vector<ShootSite>& sites) {
  if (number <= 0) return;
  double weighted_m = 0.0;
  for (const LeafyPart& part : parts) weighted_m += part.weight * part.length_m;
  const double step_m = weighted_m / number;
  double passed_m = 0.0;
  double next_m = step_m * (0.5 + 0.49 * places.next());
  for (const LeafyPart& part : parts) {
    const bool has_wood = skeleton.points[skeleton.axes[part.axis].first].radius_m > 0.0;
    const double end_m = passed_m + part.weight * part.length_m;
    for (; next_m <= end_m; next_m += step_m) {
      const double along_m = part.from_m + (next_m - passed_m) / part.weight;
      const ShootSite site{part.axis, along_m, part.whole_m - along_m};
      sites.push_back(has_wood ? site : joined(site, size_m));
    }
    passed_m = end_m;
  }
}

/// A card: its base in the middle of its lower edge.
struct Card {
  Point base{};
  Point along{};           ///< to its tip, as long as the card
  Point across{};          ///< from its middle to its right edge
  bool is_inside = false;  ///< known to be inside the crown
};

class CardWriter {
 public:
  CardWriter(const Crown& crown, const LeafyShoots& shoots, double variation, PartBuilder& build)
      : crown_(crown),
        shoots_(shoots),
        variation_(variation),
        cross_cos_(std::cos(kRadian * shoots.cross_deg)),
        cross_sin_(std::sin(kRadian * shoots.cross_deg)),
        light_(crown),
        build_(build) {}

  /// \param number  of the shoot, which gives its side of the branch
  void add(const OnAxis& place, double end, double size_m, std::uint32_t number, Jitter& jitter) {
    const Point outward = light_.outward(place.at);
    const Point along = direction_of(place, end, outward, number, jitter);
    const double size = size_m * (1.0 + 0.15 * jitter.next());
    Point base = moved_inside(place.at, along, size, 0.75 * size);
    if (!crown_.contains(base)) base = crown_.confine(base);
    crossed_cards(base, along, size, outward, number, jitter, end > 0.5 ? At::kEnd : At::kBranch);
  }

  /// The shoot at the very end of a branch, which covers its tip.
  void add_tip(const OnAxis& place, double size_m, std::uint32_t number, Jitter& jitter) {
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
    crossed_cards(base, along, size, outward, number, jitter, At::kTip);
  }

  /// A whole twig, which stays at its branch and is shorter if it would reach out of the crown.
  void add_twig(Point base, Point chord, double size_m, std::uint32_t number, Jitter& jitter) {
    const Point along = direction(direction(chord) + Point{0.0, 0.0, shoots_.lift});
    const double room = crown_.length_inside_m(base, along, size_m);
    if (room > 0.0)
      crossed_cards(base, along, room, light_.outward(base), number, jitter, At::kEnd);
  }

 private:
  /// Where a shoot is on its branch. Those at its end must cover it and are not moved.
  enum class At { kBranch, kEnd, kTip };

  /// A shoot that would reach out of the crown starts farther inside.
  Point moved_inside(Point base, Point along, double size_m, double farthest_m) const {
    const double room = crown_.length_inside_m(base, along, size_m);
    return base - std::min(size_m - room, farthest_m) * along;
  }

  /// The shoot at the end of a branch continues it, others turn off to all sides.
  Point direction_of(
      const OnAxis& place, double end, Point outward, std::uint32_t number, Jitter& jitter) const {
    const double angle = kRadian * shoots_.angle_deg * (1.0 - end) * (1.0 + 0.3 * jitter.next());
    const Point aside = direction(cross(place.along, {0.0, 0.0, 1.0}), {1.0, 0.0, 0.0});
    const double azimuth = kGoldenAngle * number + 0.4 * jitter.next();
    // Shoots of a flat spray are at its sides, those of others all round.
    const double flat = shoots_.cross_deg < 75.0 ? 0.35 : 1.0;
    const Point across =
        std::cos(azimuth) * aside + flat * std::sin(azimuth) * cross(aside, place.along);
    return direction(std::cos(angle) * place.along + std::sin(angle) * across + 0.25 * outward +
                         Point{0.0, 0.0, shoots_.lift},
                     place.along);
  }

  /// The first card faces up, or outward where the shoot is steep.
  Point upper_side(Point along, Point outward, Jitter& jitter) const {
    const Point wanted = Point{0.0, 0.0, 1.0} + 0.5 * outward +
                         0.35 * Point{jitter.next(), jitter.next(), jitter.next()};
    const Point up = wanted - dot(wanted, along) * along;
    return direction(up, direction(cross(along, {0.6, -0.48, 0.64})));
  }

  /// Two cards, each smaller if the crown has no room for it.
  void crossed_cards(Point base,
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
    const Point moved =
        at == At::kBranch ? with_room(base, size_m, {along, side, crossed}, outward) : base;
    for (const Point across : {side, crossed}) {
      const Card whole{moved, size_m * along, 0.5 * size_m * across};
      card(at == At::kTip ? fitted_to_tip(whole) : fitted(whole), picture, outward, color);
    }
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
  Card fitted(const Card& whole) const {
    const auto& [base, along, across, known] = whole;
    for (const double width : {1.0, 0.8, 0.65}) {
      const Card card{base, along, width * across, true};
      if (fits(card)) return card;
    }
    constexpr int kHalvings = 3;
    double inside = 0.3;
    double outside = 1.0;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (inside + outside);
      (fits({base, middle * along, middle * across}) ? inside : outside) = middle;
    }
    return {base, inside * along, inside * across, false};
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
    return fitted(whole);
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
    const double upper = 0.5 * static_cast<double>(picture / 2);
    std::array<LeafCorner, 4> corners{};
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double across = i == 0 || i == 3 ? -1.0 : 1.0;
      const double along = i < 2 ? 0.0 : 1.0;
      const Point corner = card.base + along * card.along + across * card.across;
      const Point at = card.is_inside ? corner : crown_.confine(corner);
      // Between the crown's surface and the card, and bulging to its edges.
      constexpr double kOfCard = 0.45;
      constexpr double kBulge = 0.35;
      const Point bulge = (kBulge * across / width) * card.across;
      const Point normal =
          direction(light_.outward(at) + CrownLight::kAbove + kOfCard * seen + bulge, seen);
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
    add_leaf_triangle(corners[0], corners[1], corners[2], build_);
    add_leaf_triangle(corners[0], corners[2], corners[3], build_);
  }

  /// Ambient occlusion: leaves deep in the crown get less light from the sky.
  Bytes4 shaded(Point at, double shade) const {
    constexpr double kInside = 0.55;
    const double open = kInside + (1.0 - kInside) * light_.share(at);
    // In steps that compress well and are not visible.
    constexpr double kSteps = 10.0;
    const std::uint8_t level =
        to_byte(std::round(kSteps * open * shade / (1.0 + variation_)) / kSteps);
    return {level, level, level, 255};
  }

  const Crown& crown_;
  const LeafyShoots& shoots_;
  double variation_;
  double cross_cos_;  ///< of the angle between the two cards
  double cross_sin_;
  CrownLight light_;
  PartBuilder& build_;
};

}  // namespace

Color brightest_shoot(const Color& mean, double variation) {
  Color color = mean;
  for (double& channel : color) channel = std::min(1.0, channel * (1.0 + variation));
  return color;
}

ShootNumber number_of_shoots(const LeafyShoots& shoots, const Crown& crown, double leafy_m) {
  const CrownRadii& r = crown.radii();
  const double area_m2 = 0.25 * std::numbers::pi * (r.east_m + r.west_m) * (r.south_m + r.north_m);
  const double covered = 2.0 * shoot_atlas(shoots.picture).covered;
  // Shoots are short in a small crown.
  const double narrowest =
      std::min({r.east_m + r.west_m, r.south_m + r.north_m, crown.h_m() - crown.hcb_m()});
  constexpr double kOfCrown = 0.2;
  const double smallest = std::min(1.0, kOfCrown * narrowest / shoots.length_m);
  constexpr double kMost = kMostShoots;
  constexpr double kLargest = 1.3;
  // Wide crowns are deep, and are assumed to have a larger leaf area index than the stand's mean.
  constexpr double kUsualWidth = 5.0;
  constexpr double kDeepest = 1.8;
  const double depth = std::clamp(r.width_m() / kUsualWidth, 1.0, kDeepest);
  const double needed = depth * shoots.leaf_area_index * area_m2 /
                        (covered * shoots.length_m * shoots.length_m);  // at scale 1
  double scale = smallest;
  if (needed > kMost * scale * scale) {
    scale = std::clamp(std::sqrt(needed / kMost), smallest, std::max(smallest, kLargest));
  }
  // At most a few shoots behind each other.
  constexpr double kDensest = 0.1;
  const double most = std::min(kMost, leafy_m / (kDensest * scale * shoots.length_m) + 1.0);
  const double number = std::clamp(needed / (scale * scale), 8.0, std::max(most, 8.0));
  // Shoots that have no room in the crown become smaller, so that narrow crowns lose a part of
  // their leaf area, by a measurement of all presets 1.7 shoots' lengths by the crown's width. All
  // shoots are larger in return.
  constexpr double kLost = 1.7;
  const double lost = std::min(kLost * scale * shoots.length_m / narrowest, 0.5);
  const double larger = std::min(scale / std::sqrt(1.0 - lost), std::max(scale, kLargest));
  return {static_cast<int>(std::lround(number)), larger};
}

void add_shoots(const Skeleton& skeleton,
                const Crown& crown,
                const LeafyShoots& shoots,
                double variation,
                Random& random,
                const MeshOptions& options,
                const WoodShift& shift,
                PartBuilder& build) {
  std::vector<LeafyPart> parts = leafy_parts(skeleton, crown);
  double leafy_m = 0.0;
  for (const LeafyPart& part : parts) leafy_m += part.length_m;
  if (!(leafy_m > 0.0)) return;
  const ShootNumber number = number_of_shoots(shoots, crown, leafy_m);
  const double larger = std::sqrt(static_cast<double>(options.foliage_per));
  const double size_m = larger * number.scale * shoots.length_m;
  Jitter places(random);
  std::vector<ShootSite> sites;
  if (shoots.is_whole_twig) {
    sites = sites_of_whole_twigs(skeleton, parts);
  } else {
    SurfaceCells(crown).follow(skeleton, parts);
    sites = sites_at_ends(skeleton, parts, size_m, options);
    const int rest = number.shoots - static_cast<int>(sites.size());
    add_sites_along(skeleton, parts, rest, size_m, places, sites);
  }

  const std::size_t drawn = sites.size() / static_cast<std::size_t>(options.foliage_per) + 2;
  build.reserve(8 * drawn, 4 * drawn);
  CardWriter writer(crown, shoots, variation, build);
  for (std::uint32_t i = 0; i < sites.size(); ++i) {
    Jitter jitter(random);
    if (i % static_cast<std::uint32_t>(options.foliage_per) != 0) continue;
    const ShootSite& site = sites[i];
    OnAxis place = on_axis(skeleton.points_of(skeleton.axes[site.axis]), site.along_m);
    if (shift) place.at = place.at + shift(site.axis, place.at);
    place.at = crown.confine(place.at);
    if (site.twig_m > 0.0) {
      const auto twig = skeleton.points_of(skeleton.axes[site.axis]);
      writer.add_twig(place.at, twig.back().at - twig.front().at, larger * site.twig_m, i, jitter);
      continue;
    }
    if (site.is_tip) {
      writer.add_tip(place, size_m, i, jitter);
      continue;
    }
    // The last shoots of a branch continue it.
    const double end = std::clamp(1.0 - site.rest_m / (0.6 * size_m), 0.0, 1.0);
    writer.add(place, end, size_m, i, jitter);
  }
}

}  // namespace silvafit::tree
