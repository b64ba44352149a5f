// SPDX-License-Identifier: MIT
#include "stand/near_crowns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <nanoflann.hpp>
#include <span>
#include <string>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/tree/overlap.hpp"

namespace silvafit::tree {
namespace {

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

}  // namespace

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
