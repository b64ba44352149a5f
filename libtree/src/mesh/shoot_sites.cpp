// SPDX-License-Identifier: MIT
#include "mesh/shoot_sites.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "mesh/boughs.hpp"
#include "mesh/jitter.hpp"
#include "mesh/level_of_detail.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/tree/texture_library.hpp"

namespace silvafit::tree {
namespace {

// Two cards are eight triangles; a tree should have no more than some twenty thousand.
constexpr std::size_t kMostShoots = 1700;
constexpr double kFlat = 1e-6;

/// A part of an axis that bears shoots.
struct LeafyPart {
  std::uint32_t axis = 0;
  double from_m = 0.0;    ///< along the axis
  double length_m = 0.0;  ///< leafy
  double whole_m = 0.0;   ///< of the axis
  double end_m = 0.0;     ///< from the last branch that it bears to its tip, or all of it
  double weight = 1.0;    ///< shoots a meter, relative to the mean
};

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
  const double crown_m = std::max(crown.h_m() - crown.hcb_m(), kFlat);
  std::vector<LeafyPart> parts;
  parts.reserve(skeleton.axes.size());
  for (std::uint32_t i = 1; i < skeleton.axes.size(); ++i) {
    constexpr double kBareBearer = 0.6;
    constexpr double kBareTwig = 0.1;
    const auto points = skeleton.points_of(skeleton.axes[i]);
    const double whole = line_length_m(points);
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
    if (layer_m_ < kFlat) return;
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

/// Length of the stem above its highest branch.
double bare_top_m(const Skeleton& skeleton) {
  double highest = 0.0;
  for (const Axis& axis : skeleton.axes) {
    if (axis.order == 1) highest = std::max(highest, skeleton.points[axis.first].at.z);
  }
  return skeleton.points_of(skeleton.axes.front()).back().at.z - highest;
}

/// The top of the stem, the ends of all branches but the thinnest, and what is bare before these
/// ends, so that all have leaves.
/// \param most_on_twigs  before their ends, if there are no shoots along them
std::vector<ShootSite> sites_at_ends(const Skeleton& skeleton,
                                     const std::vector<LeafyPart>& parts,
                                     double size_m,
                                     int most_on_twigs) {
  std::vector<ShootSite> sites;
  const double stem_m = line_length_m(skeleton.points_of(skeleton.axes.front()));
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
    constexpr double kBareTwig_m = 0.014;
    return skeleton.axes[part.axis].order == 1 || diameter_m(part) >= kBareTwig_m;
  };
  for (const LeafyPart& part : parts) {
    if (is_wood(part)) sites.push_back({part.axis, part.whole_m, 0.0, 0.0, true});
  }
  for (const LeafyPart& part : parts) {
    constexpr double kThick = 0.025;
    constexpr int kMostOnBranch = 8;
    const bool is_twig = part.end_m == part.whole_m && diameter_m(part) < kThick;
    if (!is_wood(part)) continue;
    const double leafy_m = std::min(part.end_m, part.length_m);
    const int most = is_twig ? most_on_twigs : kMostOnBranch;
    for (int i = 1; i <= most && sites.size() < kMostShoots; ++i) {
      const double back_m = kApart * i * size_m;
      if (back_m > leafy_m) break;
      sites.push_back({part.axis, part.whole_m - back_m, back_m});
    }
  }
  return sites;
}

/// All twigs, and the top of the stem.
std::vector<ShootSite> sites_of_whole_twigs(const Skeleton& skeleton,
                                            const std::vector<LeafyPart>& parts) {
  std::vector<ShootSite> sites;
  const double stem_m = line_length_m(skeleton.points_of(skeleton.axes.front()));
  std::vector<bool> bears(skeleton.axes.size(), false);
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) bears[skeleton.axes[i].parent] = true;
  for (const LeafyPart& part : parts) {
    if (!bears[part.axis]) sites.push_back({part.axis, 0.0, part.whole_m, part.whole_m});
  }
  sites.push_back({0, stem_m, 0.0});
  return sites;
}

/// Adds sites in such an order that each shoot starts near wood or near another shoot.
class SitesAlong {
 public:
  SitesAlong(const Skeleton& skeleton,
             double size_m,
             const MeshOptions& options,
             std::vector<ShootSite>& sites)
      : skeleton_(skeleton), size_m_(size_m), sites_(sites), reach_m_(skeleton.axes.size()) {
    for (std::size_t i = 0; i < reach_m_.size(); ++i) {
      const Axis& axis = skeleton.axes[i];
      const bool has_wood = i == 0 || is_drawn(axis, skeleton.points[axis.first], options);
      reach_m_[i] = has_wood ? std::numeric_limits<double>::infinity() : 0.0;
    }
  }

  /// \param rest_m  up to the end of the axis
  void add(std::uint32_t axis, double along_m, double rest_m) {
    if (std::isinf(reach_m_[axis])) {
      sites_.push_back({axis, along_m, rest_m});
      return;
    }
    // A twig that is not drawn as wood is drawn by its shoots, from its base on.
    if (reach_m_[axis] == 0.0) attach(axis);
    constexpr double kFirst = 0.3;
    constexpr double kNext = 0.8;
    const double farthest_m =
        reach_m_[axis] == 0.0 ? kFirst * size_m_ : reach_m_[axis] - (1.0 - kNext) * size_m_;
    const double here_m = std::min(along_m, farthest_m);
    sites_.push_back({.axis = axis, .along_m = here_m, .is_twig = true});
    reach_m_[axis] = here_m + size_m_;
  }

 private:
  /// Adds shoots to the bearer up to the base of an axis, if it needs them.
  void attach(std::uint32_t axis) {
    const std::uint32_t bearer = skeleton_.axes[axis].parent;
    const Point base = skeleton_.points[skeleton_.axes[axis].first].at;
    const double along_m = length(base - skeleton_.points[skeleton_.axes[bearer].first].at);
    constexpr int kMost = 8;
    for (int i = 0; i < kMost && reach_m_[bearer] < along_m; ++i) add(bearer, along_m, 0.0);
  }

  const Skeleton& skeleton_;
  double size_m_;
  std::vector<ShootSite>& sites_;
  std::vector<double> reach_m_;  ///< by axis, how far from its base its shoots reach; wood: always
};

/// A number of sites along all leafy parts, at distances by the parts' weights.
void add_sites_along(const std::vector<LeafyPart>& parts,
                     int number,
                     Jitter& places,
                     SitesAlong& along) {
  if (number <= 0) return;
  double weighted_m = 0.0;
  for (const LeafyPart& part : parts) weighted_m += part.weight * part.length_m;
  const double step_m = weighted_m / number;
  double passed_m = 0.0;
  double next_m = step_m * (0.5 + 0.49 * places.next());
  for (const LeafyPart& part : parts) {
    const double end_m = passed_m + part.weight * part.length_m;
    for (; next_m <= end_m; next_m += step_m) {
      const double here_m = part.from_m + (next_m - passed_m) / part.weight;
      along.add(part.axis, here_m, part.whole_m - here_m);
    }
    passed_m = end_m;
  }
}

/// Shoots that fill the outer part of the crown: each grows from the nearest branch, or from the
/// end of another such shoot, towards a random place, the nearest place first (as branches do by
/// space colonization: Runions, Lane and Prusinkiewicz 2007).
class CrownFill {
 public:
  CrownFill(const Skeleton& skeleton, const Crown& crown, const LeafyShoots& shoots, double size_m)
      : skeleton_(skeleton),
        crown_(crown),
        boughs_(skeleton, crown, shoots.groove),
        size_m_(size_m),
        reach_m_(shoots.reach * size_m),
        lift_(shoots.lift) {}

  void add(const std::vector<LeafyPart>& parts,
           const MeshOptions& options,
           int number,
           Jitter& random,
           std::vector<ShootSite>& sites) {
    for (const LeafyPart& part : parts) add_starts(part, options);
    if (starts_.empty()) return;
    place_targets(number, random);
    while (!targets_.empty()) {
      const auto next =
          std::min_element(targets_.begin(), targets_.end(), [](const Target& a, const Target& b) {
            return a.squared_m2 < b.squared_m2;
          });
      const Target target = *next;
      *next = targets_.back();
      targets_.pop_back();
      const Start from = starts_[target.start];
      const Point aim = direction(target.at - from.at, from.along);
      const Point along = direction(aim + Point{0.0, 0.0, lift_}, aim);
      sites.push_back({.axis = from.axis, .free = OnAxis{from.at, along}});
      // Another one may start before the end of this one.
      constexpr double kNext = 0.7;
      const double next_m = crown_.length_inside_m(from.at, along, kNext * size_m_);
      starts_.push_back({from.at + next_m * along, along, from.axis});
      for (Target& other : targets_) other.look_at(starts_, starts_.size() - 1);
    }
  }

 private:
  struct Start {
    Point at{};
    Point along{};
    std::uint32_t axis = 0;
  };
  struct Target {
    Point at{};
    std::size_t start = 0;
    double squared_m2 = std::numeric_limits<double>::infinity();

    void look_at(const std::vector<Start>& starts, std::size_t i) {
      const Point apart = at - starts[i].at;
      const double squared = dot(apart, apart);
      if (squared >= squared_m2) return;
      squared_m2 = squared;
      start = i;
    }
  };

  void add_starts(const LeafyPart& part, const MeshOptions& options) {
    const Axis& axis = skeleton_.axes[part.axis];
    if (!is_drawn(axis, skeleton_.points[axis.first], options)) return;
    const auto points = skeleton_.points_of(axis);
    const int steps = 1 + static_cast<int>(2.0 * part.length_m / size_m_);
    for (int i = 0; i <= steps; ++i) {
      const auto [at, along] =
          on_axis(points, part.from_m + part.length_m * static_cast<double>(i) / steps);
      starts_.push_back({at, along, part.axis});
    }
  }

  /// Points between the crown's surface and the same surface made smaller, near the wood.
  void place_targets(int number, Jitter& random) {
    const CrownRadii& r = crown_.radii();
    const Point middle{0.5 * (r.east_m - r.west_m),
                       0.5 * (r.north_m - r.south_m),
                       0.5 * (crown_.h_m() + crown_.hcb_m())};
    const Point half{0.5 * (r.east_m + r.west_m),
                     0.5 * (r.north_m + r.south_m),
                     0.5 * (crown_.h_m() - crown_.hcb_m())};
    const int tries = 20 * number;
    targets_.reserve(static_cast<std::size_t>(number));
    for (int i = 0; i < tries && static_cast<int>(targets_.size()) < number; ++i) {
      const Point place =
          middle + Point{half.x * random.next(), half.y * random.next(), half.z * random.next()};
      if (!crown_.contains(place) || is_deep(place)) continue;
      Target target{place};
      for (std::size_t k = 0; k < starts_.size(); ++k) target.look_at(starts_, k);
      // The wood that crosses a groove is leafy.
      constexpr double kOnWood = 0.35;
      const double reach_m = boughs_.contain(place) ? reach_m_ : kOnWood * size_m_;
      if (target.squared_m2 <= reach_m * reach_m) targets_.push_back(target);
    }
  }

  /// Whether a point is inside the crown made smaller.
  bool is_deep(Point place) const {
    constexpr double kInner = 0.55;
    const Point center{0.0, 0.0, crown_.hc_m()};
    return crown_.contains(center + 1.0 / kInner * (place - center));
  }

  const Skeleton& skeleton_;
  const Crown& crown_;
  Boughs boughs_;
  double size_m_;
  double reach_m_;
  double lift_;
  std::vector<Start> starts_{};
  std::vector<Target> targets_{};
};

/// Of the crown over its length, relative to its width where it is widest.
double mean_width(const Crown& crown) {
  constexpr int kLayers = 16;
  double sum = 0.0;
  for (int i = 0; i < kLayers; ++i) {
    const double share = (i + 0.5) / kLayers;
    sum += crown.relative_width(std::lerp(crown.hcb_m(), crown.h_m(), share)) / kLayers;
  }
  return sum;
}

}  // namespace

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

ShootNumber number_of_shoots(const LeafyShoots& shoots, const Crown& crown, double leafy_m) {
  const CrownRadii& r = crown.radii();
  const double area_m2 = 0.25 * std::numbers::pi * (r.east_m + r.west_m) * (r.south_m + r.north_m);
  const double covered = 2.0 * shoots.picture->leafy().covered;
  // Shoots are short in a small crown, and on a shrub.
  const double narrowest =
      std::min({r.east_m + r.west_m, r.south_m + r.north_m, crown.h_m() - crown.hcb_m()});
  constexpr double kOfCrown = 0.2;
  constexpr double kOfHeight = 0.1;
  const double longest_m = std::min(kOfCrown * narrowest, kOfHeight * crown.h_m());
  const double smallest = std::min(1.0, longest_m / shoots.length_m);
  constexpr double kMost = kMostShoots;
  constexpr double kLargest = 1.3;
  // Wide crowns are deep, and slender ones leave gaps between them: both are assumed to have a
  // larger leaf area index than the stand's mean.
  constexpr double kUsualWidth = 5.0;
  constexpr double kUsualSlenderness = 1.8;
  constexpr double kDeepest = 1.8;
  // Leaves on all sides of a crown get light from there, and hide its middle.
  const double filled = shoots.reach > 0.0 ? 1.5 : 1.0;
  const double slenderness = (crown.h_m() - crown.hcb_m()) / r.width_m();
  const double depth = std::clamp(
      std::max(r.width_m() / kUsualWidth, slenderness / kUsualSlenderness), 1.0, kDeepest);
  const double needed = filled * depth * shoots.leaf_area_index * area_m2 /
                        (covered * shoots.length_m * shoots.length_m);  // at scale 1
  double scale = smallest;
  if (needed > kMost * scale * scale) {
    scale = std::clamp(std::sqrt(needed / kMost), smallest, std::max(smallest, kLargest));
  }
  // At most a few shoots behind each other.
  constexpr double kDensest = 0.1;
  const double most = std::min(kMost, leafy_m / (kDensest * scale * shoots.length_m) + 1.0);
  const double number = std::clamp(needed / (scale * scale), 8.0, std::max(most, 8.0));
  // Shoots that have no room in the crown become smaller, so that narrow and pointed crowns lose a
  // part of their leaf area, by a measurement of presets 0.85 shoots' lengths by the mean of the
  // crown's width over its length. All shoots are larger in return.
  constexpr double kLost = 0.85;
  const double lost =
      std::min(kLost * scale * shoots.length_m / (mean_width(crown) * narrowest), 0.5);
  const double larger = std::min(scale / std::sqrt(1.0 - lost), std::max(scale, kLargest));
  return {static_cast<int>(std::lround(number)), larger};
}

ShootSites shoot_sites(const Skeleton& skeleton,
                       const Crown& crown,
                       const LeafyShoots& shoots,
                       Random& random,
                       const MeshOptions& options) {
  std::vector<LeafyPart> parts = leafy_parts(skeleton, crown);
  double leafy_m = 0.0;
  for (const LeafyPart& part : parts) leafy_m += part.length_m;
  if (!(leafy_m > 0.0)) return {};
  const ShootNumber number = number_of_shoots(shoots, crown, leafy_m);
  const double size_m = number.scale * shoots.length_m;
  Jitter places(random);
  if (shoots.is_whole_twig) return {size_m, sites_of_whole_twigs(skeleton, parts)};
  SurfaceCells(crown).follow(skeleton, parts);
  // The space around a drawing that is not fitted is not a crown.
  const bool fills = shoots.reach > 0.0 && crown.is_bounded();
  std::vector<ShootSite> sites = sites_at_ends(skeleton, parts, size_m, fills ? 2 : 0);
  const int rest = number.shoots - static_cast<int>(sites.size());
  if (fills) {
    CrownFill(skeleton, crown, shoots, size_m)
        .add(parts, options, std::max(rest, 0), places, sites);
    return {size_m, std::move(sites)};
  }
  SitesAlong along(skeleton, size_m, options, sites);
  add_sites_along(parts, rest, places, along);
  return {size_m, std::move(sites)};
}

}  // namespace silvafit::tree
