// SPDX-License-Identifier: MIT
#include "units/neighbor_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

namespace silvafit::stand {
namespace {

/// The points in the interface that nanoflann needs.
struct Cloud {
  std::vector<Point> points{};

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t dimension) const {
    return dimension == 0 ? points[i].x : points[i].y;
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using KdTree = nanoflann::
    KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 2, std::uint32_t>;

/// Any two points of a cell are closer than the tie tolerance.
constexpr double kCellMeters = 5e-8;
/// More than the diagonal of a cell.
constexpr double kSiteSlackMeters = 1e-7;
constexpr std::size_t kLeafSize = 12;

/// Puts a zero between the bits of a 32-bit number.
std::uint64_t spread_bits(std::uint64_t bits) {
  bits = (bits | (bits << 16)) & 0x0000ffff0000ffffU;
  bits = (bits | (bits << 8)) & 0x00ff00ff00ff00ffU;
  bits = (bits | (bits << 4)) & 0x0f0f0f0f0f0f0f0fU;
  bits = (bits | (bits << 2)) & 0x3333333333333333U;
  return (bits | (bits << 1)) & 0x5555555555555555U;
}

struct Keyed {
  std::uint64_t key = 0;
  std::uint32_t tree = 0;
};

Point lowest(std::span<const std::uint32_t> trees, std::span<const Point> positions) {
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const std::uint32_t tree : trees) {
    low = {std::min(low.x, positions[tree].x), std::min(low.y, positions[tree].y)};
  }
  return low;
}

/// Orders trees along a Z-order curve (Morton 1966), so that consecutive searches use the same
/// memory: a million trees take half the time. Trees at the same position are adjacent in the
/// order.
std::vector<Keyed> ordered_in_space(std::span<const std::uint32_t> trees,
                                    std::span<const Point> positions,
                                    Point low) {
  double extent = 1e-300;
  for (const std::uint32_t tree : trees) {
    extent = std::max({extent, positions[tree].x - low.x, positions[tree].y - low.y});
  }
  const auto cell = [extent](double offset) {
    return spread_bits(static_cast<std::uint64_t>(4294967295.0 * (offset / extent)));
  };
  std::vector<Keyed> keyed;
  keyed.reserve(trees.size());
  for (const std::uint32_t tree : trees) {
    const Point& point = positions[tree];
    keyed.push_back({cell(point.x - low.x) | (cell(point.y - low.y) << 1), tree});
  }
  std::ranges::sort(keyed, [](const Keyed& left, const Keyed& right) {
    return left.key != right.key ? left.key < right.key : left.tree < right.tree;
  });
  return keyed;
}

std::pair<std::int64_t, std::int64_t> cell_of(Point point, Point low) {
  return {static_cast<std::int64_t>(std::floor((point.x - low.x) / kCellMeters)),
          static_cast<std::int64_t>(std::floor((point.y - low.y) / kCellMeters))};
}

/// Distance from a point to the rectangle around the torus, 0 inside.
double distance_to(const Torus& torus, Point point) {
  const double east = std::max({torus.low.x - point.x, 0.0, point.x - torus.high.x});
  const double north = std::max({torus.low.y - point.y, 0.0, point.y - torus.high.y});
  return std::sqrt(east * east + north * north);
}

}  // namespace

struct NeighborSearch::Index {
  Before before{};
  std::optional<Torus> torus{};
  std::vector<std::uint32_t> trees{};
  std::vector<Point> positions{};      ///< rows of trees; none if every site has one tree
  std::vector<std::uint32_t> sites{};  ///< first tree of each site, and the end
  Cloud cloud{};                       ///< one point per site
  std::unique_ptr<KdTree> tree{};

  void add_run(std::span<const Keyed> run, std::span<const Point> all, Point low);
  void take(std::uint32_t site, std::size_t most, Point from, std::vector<Neighbor>& found) const;
  double collect(std::size_t wanted,
                 std::size_t most_of_site,
                 Point from,
                 std::vector<Neighbor>& found,
                 Scratch& scratch) const;
  double collect_images(std::size_t wanted,
                        std::size_t most_of_site,
                        Point from,
                        std::vector<Neighbor>& found,
                        Scratch& scratch) const;
  void collect_within(double reach_m,
                      std::size_t most_of_site,
                      Point from,
                      std::vector<Neighbor>& found) const;
  std::array<Point, 9> images(Point from) const;
  std::size_t site_size(std::uint32_t site) const { return sites[site + 1] - sites[site]; }
  void order(std::vector<Neighbor>& found) const;
  void leave_out(std::uint32_t tree, std::vector<Neighbor>& found) const;
  void keep_nearest_image(std::vector<Neighbor>& found) const;
};

/// Trees with equal keys: usually one, sometimes those of one or a few positions.
void NeighborSearch::Index::add_run(std::span<const Keyed> run,
                                    std::span<const Point> all,
                                    Point low) {
  const auto begin_site = [this](Point point) {
    sites.push_back(static_cast<std::uint32_t>(trees.size()));
    cloud.points.push_back(point);
  };
  if (run.size() == 1) {
    begin_site(all[run[0].tree]);
    trees.push_back(run[0].tree);
    return;
  }
  std::vector<std::pair<std::pair<std::int64_t, std::int64_t>, std::uint32_t>> cells;
  for (const Keyed& entry : run) cells.emplace_back(cell_of(all[entry.tree], low), entry.tree);
  std::ranges::sort(cells, [this](const auto& left, const auto& right) {
    if (left.first != right.first) return left.first < right.first;
    return left.second != right.second && before(left.second, right.second);
  });
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].first != cells[i - 1].first) begin_site(all[cells[i].second]);
    trees.push_back(cells[i].second);
  }
}

NeighborSearch::NeighborSearch(std::vector<std::uint32_t> trees,
                               std::span<const Point> positions,
                               Before before,
                               std::optional<Torus> torus)
    : index_(std::make_unique<Index>()) {
  Index& index = *index_;
  index.before = std::move(before);
  index.torus = torus;
  const Point low = lowest(trees, positions);
  const std::vector<Keyed> keyed = ordered_in_space(trees, positions, low);
  trees = {};
  index.trees.reserve(keyed.size());
  index.sites.reserve(keyed.size() + 1);
  index.cloud.points.reserve(keyed.size());
  for (std::size_t begin = 0; begin < keyed.size();) {
    std::size_t end = begin + 1;
    while (end < keyed.size() && keyed[end].key == keyed[begin].key) ++end;
    index.add_run(std::span(keyed).subspan(begin, end - begin), positions, low);
    begin = end;
  }
  index.sites.push_back(static_cast<std::uint32_t>(index.trees.size()));
  if (index.cloud.points.size() < index.trees.size()) {
    for (const std::uint32_t tree : index.trees) index.positions.push_back(positions[tree]);
  }
  index.tree = std::make_unique<KdTree>(
      2, index.cloud, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
}

NeighborSearch::~NeighborSearch() = default;
NeighborSearch::NeighborSearch(NeighborSearch&&) noexcept = default;
NeighborSearch& NeighborSearch::operator=(NeighborSearch&&) noexcept = default;

const std::vector<std::uint32_t>& NeighborSearch::trees() const { return index_->trees; }

/// Adds the first trees of a site.
void NeighborSearch::Index::take(std::uint32_t site,
                                 std::size_t most,
                                 Point from,
                                 std::vector<Neighbor>& found) const {
  const std::size_t first = sites[site];
  const std::size_t end = first + std::min(site_size(site), most);
  for (std::size_t i = first; i < end; ++i) {
    const Point point = positions.empty() ? cloud.points[site] : positions[i];
    const double east = point.x - from.x;
    const double north = point.y - from.y;
    found.push_back({trees[i], std::sqrt(east * east + north * north), east, north});
  }
}

/// Adds the trees of the nearest sites; returns the distance within which all sites were added.
double NeighborSearch::Index::collect(std::size_t wanted,
                                      std::size_t most_of_site,
                                      Point from,
                                      std::vector<Neighbor>& found,
                                      Scratch& scratch) const {
  scratch.sites.resize(wanted);
  scratch.squares.resize(wanted);
  const std::array<double, 2> query{from.x, from.y};
  const std::size_t got =
      tree->knnSearch(query.data(), wanted, scratch.sites.data(), scratch.squares.data());
  for (std::size_t i = 0; i < got; ++i) take(scratch.sites[i], most_of_site, from, found);
  return got < wanted ? std::numeric_limits<double>::infinity() : std::sqrt(scratch.squares.back());
}

/// The position itself and its eight images around the torus.
std::array<Point, 9> NeighborSearch::Index::images(Point from) const {
  const double width = torus->high.x - torus->low.x;
  const double height = torus->high.y - torus->low.y;
  std::array<Point, 9> all{from};
  std::size_t next = 1;
  for (const double east : {-1.0, 0.0, 1.0}) {
    for (const double north : {-1.0, 0.0, 1.0}) {
      if (east == 0.0 && north == 0.0) continue;
      all[next++] = {from.x + east * width, from.y + north * height};
    }
  }
  return all;
}

/// As collect, for a torus: images that are too far away are skipped.
double NeighborSearch::Index::collect_images(std::size_t wanted,
                                             std::size_t most_of_site,
                                             Point from,
                                             std::vector<Neighbor>& found,
                                             Scratch& scratch) const {
  double seen_m = std::numeric_limits<double>::infinity();
  for (const Point& image : images(from)) {
    if (distance_to(*torus, image) > seen_m) continue;
    seen_m = std::min(seen_m, collect(wanted, most_of_site, image, found, scratch));
  }
  keep_nearest_image(found);
  return seen_m;
}

/// Adds trees of all sites within a distance; on a torus the nearest image of each.
void NeighborSearch::Index::collect_within(double reach_m,
                                           std::size_t most_of_site,
                                           Point from,
                                           std::vector<Neighbor>& found) const {
  std::vector<std::pair<std::uint32_t, double>> near;
  const auto search = [&](Point center) {
    const std::array<double, 2> query{center.x, center.y};
    tree->radiusSearch(
        query.data(), reach_m * reach_m, near, nanoflann::SearchParams(32, 0.0F, false));
    for (const auto& site : near) take(site.first, most_of_site, center, found);
  };
  if (!torus) return search(from);
  for (const Point& image : images(from)) {
    if (distance_to(*torus, image) <= reach_m) search(image);
  }
  keep_nearest_image(found);
}

/// The nearest image of each tree; of two at the same distance, the one farther east and north.
void NeighborSearch::Index::keep_nearest_image(std::vector<Neighbor>& found) const {
  std::ranges::sort(found, [](const Neighbor& left, const Neighbor& right) {
    if (left.tree != right.tree) return left.tree < right.tree;
    if (std::abs(left.distance_m - right.distance_m) > kSameDistanceMeters) {
      return left.distance_m < right.distance_m;
    }
    return std::pair(left.east_m, left.north_m) > std::pair(right.east_m, right.north_m);
  });
  // Not std::ranges::unique, because clang 14 does not support structured bindings of its result.
  const auto is_same_tree = [](const Neighbor& left, const Neighbor& right) {
    return left.tree == right.tree;
  };
  found.erase(std::unique(found.begin(), found.end(), is_same_tree), found.end());
}

/// By distance; trees within the tie tolerance of the first of them in the order of the trees.
void NeighborSearch::Index::order(std::vector<Neighbor>& found) const {
  std::ranges::sort(found, [](const Neighbor& left, const Neighbor& right) {
    return left.distance_m != right.distance_m ? left.distance_m < right.distance_m
                                               : left.tree < right.tree;
  });
  for (auto first = found.begin(); first != found.end();) {
    auto last = first + 1;
    while (last != found.end() && last->distance_m - first->distance_m <= kSameDistanceMeters) {
      ++last;
    }
    if (last - first > 1) {
      std::sort(first, last, [this](const Neighbor& a, const Neighbor& b) {
        return a.tree != b.tree && before(a.tree, b.tree);
      });
    }
    first = last;
  }
}

void NeighborSearch::Index::leave_out(std::uint32_t tree_itself,
                                      std::vector<Neighbor>& found) const {
  const auto itself = std::ranges::find(found, tree_itself, &Neighbor::tree);
  if (itself != found.end()) found.erase(itself);
}

void NeighborSearch::nearest(std::size_t position,
                             std::size_t count,
                             std::vector<Neighbor>& found,
                             Scratch& scratch) const {
  const Index& index = *index_;
  const std::uint32_t tree = index.trees[position];
  const Point from =
      index.positions.empty() ? index.cloud.points[position] : index.positions[position];
  const std::size_t most_of_site = count + 1;
  constexpr double kUndecided = kSameDistanceMeters + kSiteSlackMeters;
  // One for the tree itself, one to test whether the last neighbor ties with the next.
  for (std::size_t wanted = count + 2;; wanted *= 2) {
    found.clear();
    const double seen_m = index.torus
                              ? index.collect_images(wanted, most_of_site, from, found, scratch)
                              : index.collect(wanted, most_of_site, from, found, scratch);
    index.leave_out(tree, found);
    index.order(found);
    if (std::isinf(seen_m)) break;
    if (found.size() < count) continue;
    const double last_m = found[count - 1].distance_m;
    if (seen_m - last_m > kUndecided) break;
    // There may be very many ties, and the time of a search for so many nearest sites grows with
    // the square of their number; that of a search within a distance does not.
    found.clear();
    index.collect_within(last_m + 2.0 * kUndecided, most_of_site, from, found);
    index.leave_out(tree, found);
    index.order(found);
    break;
  }
  if (found.size() > count) found.resize(count);
}

void NeighborSearch::within(std::size_t position,
                            double radius_m,
                            std::vector<Neighbor>& found) const {
  const Index& index = *index_;
  const Point from =
      index.positions.empty() ? index.cloud.points[position] : index.positions[position];
  found.clear();
  index.collect_within(
      radius_m + kSiteSlackMeters, std::numeric_limits<std::size_t>::max(), from, found);
  index.leave_out(index.trees[position], found);
  std::erase_if(found, [radius_m](const Neighbor& neighbor) {
    return neighbor.distance_m > radius_m + kSameDistanceMeters;
  });
  index.order(found);
}

}  // namespace silvafit::stand
