// SPDX-License-Identifier: MIT
#include <cmath>
#include <vector>

#include "mesh/foliage.hpp"
#include "mesh/leaf_surface.hpp"

namespace silvafit::tree {
namespace {

// A twig has its base, an edge and four tips; four leaves of two triangles, and a filling.
constexpr std::size_t kPointsPerTwig = 6;
constexpr std::size_t kLeavesPerTwig = 4;
constexpr std::size_t kTrianglesPerTwig = 9;

/// A twig of a frond relative to its side of the branch.
struct FrondTwig {
  Point base{};
  Point tip{};
};

/// One side of a frond, from the branch's base to its tip.
class FrondSide {
 public:
  FrondSide(const Foliage& foliage, const MeshOptions& options, LeafSurface& surface)
      : foliage_(foliage), options_(options), surface_(surface) {}

  /// \param ribs    indices of the points where the twigs start, and at the end of the branch's tip
  /// \param inmost  index of the point on the branch below the first twig
  void add(const std::vector<FrondTwig>& twigs,
           const std::vector<std::size_t>& ribs,
           std::size_t inmost) {
    std::size_t before = inmost;
    for (std::size_t i = 0; i < twigs.size(); ++i) {
      const Point along = twigs[i].tip - twigs[i].base;
      const Point next_base = surface_.at(ribs[i + 1]);
      const Point next_along =
          i + 1 < twigs.size() ? twigs[i + 1].tip - twigs[i + 1].base : Point{};
      Point edge =
          0.5 * (twigs[i].base + next_base) + 0.5 * foliage_.fullness * (along + next_along);
      edge.z -= foliage_.droop * 0.5 * foliage_.fullness * length(along);
      const std::size_t after = surface_.point(edge);
      add_tips(twigs[i], along, ribs[i], before, after, next_base);
      surface_.triangle(ribs[i], after, ribs[i + 1]);
      before = after;
    }
  }

 private:
  /// Spikes along, above and below the twig; of the upper ones, one leans to the branch's tip and
  /// one back. A coarser level has only the middle one.
  void add_tips(const FrondTwig& twig,
                Point along,
                std::size_t rib,
                std::size_t before,
                std::size_t after,
                Point next_base) {
    surface_.leaf(rib, before, surface_.point(twig.tip), after);
    if (options_.foliage_per > 1) return;
    constexpr double kShorter = 0.85;
    constexpr double kLean = 0.3;
    const double size = length(along);
    const Point forward = kLean * size * direction(next_base - twig.base);
    const Point rise = {0.0, 0.0, foliage_.lift * size};
    const Point middle = twig.base + kShorter * along;
    constexpr Point kUp = {0.0, 0.0, 0.4};
    surface_.leaf(rib, before, surface_.point(middle + forward + rise, kUp), after);
    surface_.leaf(rib, before, surface_.point(middle - forward + 0.5 * rise, kUp), after);
    surface_.leaf(rib, before, surface_.point(middle - rise, -1.0 * kUp), after);
  }

  const Foliage& foliage_;
  const MeshOptions& options_;
  LeafSurface& surface_;
};

class FrondGrower {
 public:
  FrondGrower(const Skeleton& skeleton,
              const Crown& crown,
              const Foliage& foliage,
              const MeshOptions& options,
              PartBuilder& build)
      : skeleton_(skeleton), foliage_(foliage), options_(options), surface_(crown, build) {}

  /// The frond of a first-order branch; `children` are the axes that grow from it.
  void add(const Axis& branch, std::span<const Axis> children) {
    const auto points = skeleton_.points_of(branch);
    const Point tip = points.back().at;
    const Point sideways =
        direction(cross({0.0, 0.0, 1.0}, tip - points.front().at), {1.0, 0.0, 0.0});
    for (std::vector<FrondTwig>* side : {&left_, &right_}) side->clear();
    for (const Axis& child : children) {
      const auto twig = skeleton_.points_of(child);
      const FrondTwig added{twig.front().at, twig.back().at};
      (dot(added.tip - added.base, sideways) >= 0.0 ? left_ : right_).push_back(added);
    }
    thin(left_);
    thin(right_);
    const std::size_t twigs = left_.size() + right_.size();
    surface_.begin(kPointsPerTwig * twigs + 2, kLeavesPerTwig * twigs, twigs);
    const std::size_t inmost = surface_.point(middle_of_bare_part(points, children));
    const std::size_t end = surface_.point(tip);
    shared_.clear();
    FrondSide side(foliage_, options_, surface_);
    side.add(left_, ribs_of(left_, end), inmost);
    side.add(right_, ribs_of(right_, end), inmost);
  }

 private:
  /// Every n-th twig of a side, the middle ones of each n; the outline of the frond is kept, and
  /// the gaps are filled as before.
  void thin(std::vector<FrondTwig>& twigs) const {
    const auto per = static_cast<std::size_t>(options_.foliage_per);
    if (per == 1 || twigs.empty()) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < twigs.size(); i += per) {
      const std::size_t group = std::min(per, twigs.size() - i);
      twigs[kept++] = twigs[i + (group - 1) / 2];
    }
    twigs.resize(kept);
  }

  static Point middle_of_bare_part(std::span<const SkeletonPoint> points,
                                   std::span<const Axis> children) {
    if (children.empty()) return points[points.size() - 2].at;
    return 0.5 * (points[0].at + points[1].at);
  }

  /// Points where the twigs start; twigs of a pair share them.
  const std::vector<std::size_t>& ribs_of(const std::vector<FrondTwig>& twigs, std::size_t end) {
    ribs_.clear();
    for (const FrondTwig& twig : twigs) {
      std::size_t number = end;
      for (const SharedRib& rib : shared_) {
        if (length(rib.base - twig.base) == 0.0) number = rib.number;
      }
      if (number == end) {
        number = surface_.point(twig.base);
        shared_.push_back({twig.base, number});
      }
      ribs_.push_back(number);
    }
    ribs_.push_back(end);
    return ribs_;
  }

  struct SharedRib {
    Point base{};
    std::size_t number = 0;
  };

  const Skeleton& skeleton_;
  const Foliage& foliage_;
  const MeshOptions& options_;
  LeafSurface surface_;
  std::vector<FrondTwig> left_;
  std::vector<FrondTwig> right_;
  std::vector<std::size_t> ribs_;
  std::vector<SharedRib> shared_;
};

}  // namespace

void add_needles(const Skeleton& skeleton,
                 const Crown& crown,
                 const Foliage& foliage,
                 const MeshOptions& options,
                 PartBuilder& build) {
  const std::span<const Axis> axes = skeleton.axes;
  build.reserve(kPointsPerTwig * axes.size(), kTrianglesPerTwig * axes.size());
  FrondGrower fronds(skeleton, crown, foliage, options, build);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (axes[i].order != 1) continue;
    std::size_t last = i + 1;
    while (last < axes.size() && axes[last].order > 1) ++last;
    fronds.add(axes[i], axes.subspan(i + 1, last - i - 1));
  }
}

}  // namespace silvafit::tree
