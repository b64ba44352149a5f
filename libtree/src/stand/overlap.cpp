// SPDX-License-Identifier: MIT
#include "silvafit/tree/overlap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <nanoflann.hpp>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/tree/mesh.hpp"
#include "stand/radius_branch.hpp"

namespace silvafit::tree {
namespace {

/// The circle around a stem that contains the tree's crown.
struct CrownCircle {
  std::string_view plot{};
  std::string_view tree{};
  Position stem{};
  double radius_m = 0.0;
};

/// Stems in the interface that nanoflann needs.
struct StemPlaces {
  const std::vector<CrownCircle>& crowns;

  std::size_t kdtree_get_point_count() const { return crowns.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return axis == 0 ? crowns[i].stem.x_m : crowns[i].stem.y_m;
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using StemTree = nanoflann::
    KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, StemPlaces>, StemPlaces, 2>;

class CrownSearch {
 public:
  explicit CrownSearch(const std::vector<CrownCircle>& crowns)
      : crowns_(crowns),
        places_{crowns},
        index_(2, places_, nanoflann::KDTreeSingleIndexAdaptorParams(10)) {
    for (const CrownCircle& crown : crowns) widest_ = std::max(widest_, crown.radius_m);
  }

  std::vector<std::size_t> near(std::size_t i) const {
    const CrownCircle& own = crowns_[i];
    const double at[2] = {own.stem.x_m, own.stem.y_m};
    std::vector<std::pair<std::uint32_t, double>> found;
    const double reach = own.radius_m + widest_;
    index_.radiusSearch(at, reach * reach, found, nanoflann::SearchParams());
    std::vector<std::size_t> result;
    for (const auto& [j, squared] : found) {
      const double both = own.radius_m + crowns_[j].radius_m;
      if (j != i && squared < both * both) result.push_back(j);
    }
    std::sort(result.begin(), result.end());
    return result;
  }

 private:
  const std::vector<CrownCircle>& crowns_;
  StemPlaces places_;
  StemTree index_;
  double widest_ = 0.0;
};

// Neighbors of one tree, and of all, with which overlaps are resolved in minutes: in dense natural
// regeneration a tree has some 60.
constexpr std::size_t kMostNear = 500;
constexpr std::size_t kMostNearOnAverage = 100;
constexpr std::size_t kMostNearOfFew = 10000;

/// Names the first tree at which the stand becomes too dense, for any order of the threads.
[[noreturn]] void refuse_density(const std::vector<CrownCircle>& crowns,
                                 const CrownSearch& search,
                                 std::size_t most_of_all) {
  std::size_t sum = 0;
  for (std::size_t i = 0;; ++i) {
    const std::size_t count = search.near(i).size();
    sum += count;
    if (count <= kMostNear && sum <= most_of_all && i + 1 < crowns.size()) continue;
    throw GeometryError(
        fmt::format("overlaps cannot be resolved: the crowns of {} other trees reach the crown of "
                    "this one, and at most {} in one place and {} on average are possible; check "
                    "positions and crown widths, or omit `resolve_overlaps`",
                    count,
                    kMostNear,
                    kMostNearOnAverage),
        {.plot = std::string(crowns[i].plot), .tree = std::string(crowns[i].tree)});
  }
}

/// For each crown every other crown that could touch it, in increasing order.
/// \param threads  0: one for each core
/// \throws GeometryError with the tree if more crowns meet in one place than resolve_overlaps() can
///   resolve in minutes
std::vector<std::vector<std::size_t>> near_crowns(const std::vector<CrownCircle>& crowns,
                                                  unsigned threads) {
  std::vector<std::vector<std::size_t>> near(crowns.size());
  if (crowns.empty()) return near;
  const CrownSearch search(crowns);
  const std::size_t most_of_all = kMostNearOfFew + kMostNearOnAverage * crowns.size();
  std::atomic<std::size_t> sum{0};
  std::atomic<bool> is_too_dense{false};
  parallel_for(crowns.size(), threads, [&](std::size_t i) {
    if (is_too_dense) return;
    near[i] = search.near(i);
    if (near[i].size() > kMostNear || (sum += near[i].size()) > most_of_all) is_too_dense = true;
  });
  if (is_too_dense) refuse_density(crowns, search, most_of_all);
  return near;
}

using Lanes = std::shared_ptr<const std::vector<Lane>>;

Point between(const Position& from, const Position& to) {
  return {to.x_m - from.x_m, to.y_m - from.y_m, to.z_m - from.z_m};
}

/// The other trees whose crowns could touch each tree's.
std::vector<std::vector<std::size_t>> near_trees(std::span<const StandTree> trees,
                                                 unsigned threads) {
  std::vector<CrownCircle> crowns;
  crowns.reserve(trees.size());
  for (const StandTree& tree : trees) {
    crowns.push_back({.plot = tree.plot,
                      .tree = tree.tree,
                      .stem = tree.position,
                      .radius_m = tree.crown->radii().widest_m()});
  }
  return near_crowns(crowns, threads);
}

/// Whether the first is the weaker tree; of two equal ones, the one whose name comes first.
bool is_weaker(const StandTree& first, const StandTree& second) {
  const auto weaker =
      first_is_weaker(competition(facing(*first.crown, first.position, second.position),
                                  facing(*second.crown, second.position, first.position)));
  if (weaker) return *weaker;
  return std::tie(first.plot, first.tree) < std::tie(second.plot, second.tree);
}

// ---- Radius branches --------------------------------------------------------------------------

/// The courses of all radius branches, and the lanes around them and around the stems.
class RadiusBranches {
 public:
  RadiusBranches(std::span<const StandTree> trees,
                 const std::vector<std::vector<std::size_t>>& near,
                 unsigned threads)
      : trees_(trees),
        near_(near),
        threads_(threads),
        courses_(trees.size()),
        crossing_(trees.size()) {
    for (std::size_t i = 0; i < trees.size(); ++i) courses_[i] = trees[i].radius_branches;
    draw_lanes();
  }

  /// Turns the weaker trees' branches. A turned branch may come near that of a third tree. A few
  /// iterations, each from the complete previous result, solve this for any order of the trees.
  void turn() {
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      std::vector<std::vector<BranchLine>> next = courses_;
      parallel_for(trees_.size(), threads_, [&](std::size_t i) { next[i] = turned_of(i); });
      const bool settled = is_same(next);
      courses_ = std::move(next);
      draw_lanes();
      if (settled) break;
    }
    parallel_for(trees_.size(), threads_, [&](std::size_t i) { crossing_[i] = count_crossing(i); });
  }

  const Lanes& lanes(std::size_t tree) const { return lanes_[tree]; }
  std::size_t crossing(std::size_t tree) const { return crossing_[tree]; }

  std::vector<BranchLine> changed(std::size_t tree) const {
    std::vector<BranchLine> lines;
    for (std::size_t k = 0; k < courses_[tree].size(); ++k) {
      if (!is_same_line(courses_[tree][k].points, trees_[tree].radius_branches[k].points)) {
        lines.push_back(courses_[tree][k]);
      }
    }
    return lines;
  }

 private:
  bool is_same(const std::vector<std::vector<BranchLine>>& next) const {
    for (std::size_t i = 0; i < next.size(); ++i) {
      for (std::size_t k = 0; k < next[i].size(); ++k) {
        if (!is_same_line(next[i][k].points, courses_[i][k].points)) return false;
      }
    }
    return true;
  }

  void draw_lanes() {
    lanes_.resize(trees_.size());
    parallel_for(trees_.size(), threads_, [&](std::size_t i) {
      std::vector<Lane> lanes{lane_round(trees_[i].stem.line())};
      for (const BranchLine& line : courses_[i]) lanes.push_back(lane_round(line.points));
      lanes_[i] = std::make_shared<const std::vector<Lane>>(std::move(lanes));
    });
  }

  /// The stems of all neighbors, and the radius branches of the stronger ones.
  std::vector<Obstacle> obstacles_of(std::size_t i) const {
    std::vector<Obstacle> obstacles;
    for (const std::size_t j : near_[i]) {
      const Point stem = between(trees_[i].position, trees_[j].position);
      const bool must_avoid_branches = is_weaker(trees_[i], trees_[j]);
      const std::size_t number = must_avoid_branches ? lanes_[j]->size() : 1;
      for (std::size_t k = 0; k < number; ++k) obstacles.push_back({&(*lanes_[j])[k], stem});
    }
    return obstacles;
  }

  std::vector<BranchLine> turned_of(std::size_t i) const {
    const std::vector<Obstacle> obstacles = obstacles_of(i);
    std::vector<BranchLine> lines = trees_[i].radius_branches;
    for (BranchLine& line : lines) {
      if (line.bears) continue;
      const Point base = line.points.front().at;
      const bool on_stem = base.x == 0.0 && base.y == 0.0;
      line.points = turned(line.points, on_stem, *trees_[i].crown, obstacles);
    }
    return lines;
  }

  std::size_t count_crossing(std::size_t i) const {
    const std::vector<Obstacle> obstacles = obstacles_of(i);
    return static_cast<std::size_t>(
        std::count_if(courses_[i].begin(), courses_[i].end(), [&](const BranchLine& line) {
          // The lane's margin is added to the wood's radius; without it wood could touch wood.
          return clearance_m(line.points, obstacles) + kLaneMargin < 0.0;
        }));
  }

  std::span<const StandTree> trees_;
  const std::vector<std::vector<std::size_t>>& near_;
  unsigned threads_;
  std::vector<std::vector<BranchLine>> courses_;
  std::vector<Lanes> lanes_;
  std::vector<std::size_t> crossing_;
};

// ---- Pairs ------------------------------------------------------------------------------------

/// A branch that enters the neighbor's crown.
struct Overlapping {
  std::uint32_t axis = 0;
  double beyond = -kInfinity;  ///< largest ln(s_own / s_neighbor) along it; > 0 past the middle
  bool crosses_lane = false;
};

/// ln(s_own / s_neighbor), of the wood's side that is farthest from its own axis and nearest to
/// the neighbor's; minus infinity outside the neighbor's crown.
double log_ratio(const Crown& own, const Crown& other, const SkeletonPoint& wood, Point stem) {
  const double theirs = relative_distance(other, wood.at - stem, -wood.radius_m - kClearance);
  if (theirs >= 1.0) return -kInfinity;
  const double ours = relative_distance(own, wood.at, wood.radius_m + kClearance);
  if (ours == 0.0) return -kInfinity;
  return theirs == 0.0 ? kInfinity : std::log(ours / theirs);
}

class PairResolver {
 public:
  PairResolver(std::span<const StandTree> trees, const RadiusBranches& radius_branches)
      : trees_(trees), radius_branches_(radius_branches) {}

  struct Result {
    PairOverlap pair{};
    std::vector<std::uint32_t> removed_weaker{};
    std::vector<std::uint32_t> removed_stronger{};
  };

  Result resolve(std::size_t weaker, std::size_t stronger) const {
    Result result;
    PairOverlap& pair = result.pair;
    const StandTree& first = trees_[weaker];
    const StandTree& second = trees_[stronger];
    const FacingCrown first_crown = facing(*first.crown, first.position, second.position);
    const FacingCrown second_crown = facing(*second.crown, second.position, first.position);
    pair.weaker = weaker;
    pair.stronger = stronger;
    pair.distance_m = level_distance_m(first.position, second.position);
    pair.facing_radii_m = first_crown.radius_m + second_crown.radius_m;
    pair.competition = competition(first_crown, second_crown);
    pair.meeting = crown_meeting(first_crown, second_crown, pair.distance_m);
    std::vector<Overlapping> of_first = overlapping(weaker, stronger);
    std::vector<Overlapping> of_second = overlapping(stronger, weaker);
    remove(of_first, of_second, result);
    pair.removed_weaker = result.removed_weaker.size();
    pair.removed_stronger = result.removed_stronger.size();
    return result;
  }

 private:
  /// Branches of a tree that enter its neighbor's crown or lanes, those that reach farthest
  /// first.
  std::vector<Overlapping> overlapping(std::size_t own, std::size_t other) const {
    const StandTree& tree = trees_[own];
    const Point stem = between(tree.position, trees_[other].position);
    const Crown& crown = *trees_[other].crown;
    const double reach = crown.radii().widest_m();
    const std::vector<Lane>& lanes = *radius_branches_.lanes(other);
    const std::vector<Lane>& own_lanes = *radius_branches_.lanes(own);
    std::vector<Overlapping> found;
    for (const BranchLine& branch : tree.branches) {
      if (distance_from_line(branch, stem) > reach + kClearance) continue;
      Overlapping one{branch.axis};
      walk(branch.points, [&](double, const SkeletonPoint& point) {
        // As Territory::holds(): a branch in the tree's own lane never conflicts.
        for (const Lane& lane : own_lanes) {
          if (lane.touches(point.at)) return true;
        }
        const Point at = point.at - stem;
        for (const Lane& lane : lanes) {
          one.crosses_lane = one.crosses_lane || lane.touches(at, point.radius_m);
        }
        one.beyond = std::max(one.beyond, log_ratio(*tree.crown, crown, point, stem));
        return true;
      });
      if (one.crosses_lane || one.beyond > -kInfinity) found.push_back(one);
    }
    std::ranges::sort(found, {}, [](const Overlapping& one) {
      return std::tuple(!one.crosses_lane, -one.beyond, one.axis);
    });
    return found;
  }

  /// Horizontal distance of a point from the box around a branch: never more than from the branch.
  static double distance_from_line(const BranchLine& branch, Point place) {
    double left = kInfinity, right = -kInfinity, low = kInfinity, high = -kInfinity;
    for (const SkeletonPoint& point : branch.points) {
      left = std::min(left, point.at.x - point.radius_m);
      right = std::max(right, point.at.x + point.radius_m);
      low = std::min(low, point.at.y - point.radius_m);
      high = std::max(high, point.at.y + point.radius_m);
    }
    return std::hypot(place.x - std::clamp(place.x, left, right),
                      place.y - std::clamp(place.y, low, high));
  }

  /// Removes alternately until a meeting surface separates the remaining branches.
  static void remove(const std::vector<Overlapping>& of_first,
                     const std::vector<Overlapping>& of_second,
                     Result& result) {
    // One of the weaker per Ct of the stronger. If the ratios of radii and heights
    // disagree, Ct can exceed 1 for the weaker tree; the stronger never loses more than one
    // for one.
    const double share = std::min(result.pair.competition.total, 1.0);
    std::size_t first = 0;
    std::size_t second = 0;
    const auto greatest = [](const std::vector<Overlapping>& left, std::size_t from) {
      if (from == left.size()) return -kInfinity;
      if (left[from].crosses_lane) return kInfinity;
      return left[from].beyond;
    };
    while (true) {
      const double beyond_first = greatest(of_first, first);
      const double beyond_second = greatest(of_second, second);
      const bool in_lane = beyond_first == kInfinity || beyond_second == kInfinity;
      const bool any_is_clear = beyond_first == -kInfinity || beyond_second == -kInfinity;
      if (!in_lane && (any_is_clear || beyond_first + beyond_second <= 0.0)) {
        const double at_least = beyond_first;
        const double at_most = -beyond_second;
        result.pair.log_share = std::clamp(0.0, at_least, at_most);
        break;
      }
      bool from_first = share * static_cast<double>(first) <= static_cast<double>(second);
      // Branches in a lane must be removed in any case.
      if (in_lane && beyond_first != kInfinity) from_first = false;
      if (in_lane && beyond_second != kInfinity) from_first = true;
      if (from_first) {
        result.removed_weaker.push_back(of_first[first++].axis);
      } else {
        result.removed_stronger.push_back(of_second[second++].axis);
      }
    }
  }

  std::span<const StandTree> trees_;
  const RadiusBranches& radius_branches_;
};

/// Indices by plot and tree.
std::vector<std::size_t> ranks_of(std::span<const StandTree> trees) {
  std::vector<std::size_t> order(trees.size());
  std::iota(order.begin(), order.end(), 0);
  const auto name = [&](std::size_t i) { return std::tie(trees[i].plot, trees[i].tree); };
  std::ranges::sort(order, {}, name);
  std::vector<std::size_t> ranks(trees.size());
  for (std::size_t r = 0; r < order.size(); ++r) {
    if (r > 0 && name(order[r - 1]) == name(order[r])) {
      const StandTree& twice = trees[order[r]];
      throw UsageError("two trees of the stand have the same label",
                       {.plot = twice.plot, .tree = twice.tree});
    }
    ranks[order[r]] = r;
  }
  return ranks;
}

std::vector<std::pair<std::size_t, std::size_t>> weaker_and_stronger(
    std::span<const StandTree> trees,
    const std::vector<std::vector<std::size_t>>& near,
    const std::vector<std::size_t>& ranks) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    for (const std::size_t j : near[i]) {
      if (is_weaker(trees[i], trees[j])) pairs.emplace_back(i, j);
    }
  }
  std::ranges::sort(pairs, {}, [&](const auto& pair) {
    return std::pair(ranks[pair.first], ranks[pair.second]);
  });
  return pairs;
}

}  // namespace

StandOverlap resolve_overlaps(std::span<const StandTree> trees, unsigned threads) {
  const std::vector<std::size_t> ranks = ranks_of(trees);
  const auto near = near_trees(trees, threads);
  RadiusBranches radius_branches(trees, near, threads);
  radius_branches.turn();
  const auto pairs = weaker_and_stronger(trees, near, ranks);
  const PairResolver resolver(trees, radius_branches);
  std::vector<PairResolver::Result> results(pairs.size());
  parallel_for(pairs.size(), threads, [&](std::size_t p) {
    results[p] = resolver.resolve(pairs[p].first, pairs[p].second);
  });

  StandOverlap stand;
  stand.trees.resize(trees.size());
  std::vector<std::vector<Territory::Neighbor>> neighbors(trees.size());
  const auto add = [&](std::size_t own,
                       std::size_t other,
                       double log_share,
                       const std::vector<std::uint32_t>& removed) {
    neighbors[own].push_back({.crown = trees[other].crown,
                              .stem = between(trees[own].position, trees[other].position),
                              .log_share = log_share,
                              .lanes = radius_branches.lanes(other)});
    std::vector<std::uint32_t>& all = stand.trees[own].removed;
    all.insert(all.end(), removed.begin(), removed.end());
  };
  for (const PairResolver::Result& result : results) {
    const PairOverlap& pair = result.pair;
    add(pair.weaker, pair.stronger, pair.log_share, result.removed_weaker);
    add(pair.stronger, pair.weaker, -pair.log_share, result.removed_stronger);
    if (pair.facing_radii_m > pair.distance_m) stand.pairs.push_back(pair);
  }
  for (std::size_t i = 0; i < trees.size(); ++i) {
    TreeOverlap& tree = stand.trees[i];
    std::sort(tree.removed.begin(), tree.removed.end());
    tree.removed.erase(std::unique(tree.removed.begin(), tree.removed.end()), tree.removed.end());
    tree.turned = radius_branches.changed(i);
    tree.crossing = radius_branches.crossing(i);
    for (const BranchLine& line : trees[i].radius_branches) tree.lanes.push_back(line.axis);
    tree.territory = Territory(trees[i].crown, radius_branches.lanes(i), std::move(neighbors[i]));
  }
  return stand;
}

void check_crown_density(std::span<const Morphology> trees, unsigned threads) {
  std::vector<CrownCircle> crowns;
  crowns.reserve(trees.size());
  for (const Morphology& tree : trees) {
    const double of_width = tree.cw_m.value_or(0.0) / 2.0;
    crowns.push_back({.plot = tree.plot,
                      .tree = tree.tree,
                      .stem = tree.position,
                      .radius_m = tree.radii ? tree.radii->widest_m() : of_width});
  }
  near_crowns(crowns, threads);
}

}  // namespace silvafit::tree
