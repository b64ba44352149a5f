// SPDX-License-Identifier: MIT
#include "neighbor_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

namespace silvafit::stand {
namespace {

/// The points as nanoflann wants to see them.
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

/// Puts a zero between the bits of a 16-bit number.
std::uint32_t spread_bits(std::uint32_t bits) {
  bits = (bits | (bits << 8)) & 0x00ff00ffU;
  bits = (bits | (bits << 4)) & 0x0f0f0f0fU;
  bits = (bits | (bits << 2)) & 0x33333333U;
  return (bits | (bits << 1)) & 0x55555555U;
}

/// Orders trees along a Z-shaped curve through space (Morton 1966), so that consecutive searches
/// touch the same memory: a million trees take half the time.
void order_in_space(std::vector<std::uint32_t>& trees, std::span<const Point> positions) {
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point high{-low.x, -low.y};
  for (const std::uint32_t tree : trees) {
    low = {std::min(low.x, positions[tree].x), std::min(low.y, positions[tree].y)};
    high = {std::max(high.x, positions[tree].x), std::max(high.y, positions[tree].y)};
  }
  const double extent = std::max({high.x - low.x, high.y - low.y, 1e-300});
  const auto cell = [extent](double offset) {
    return spread_bits(static_cast<std::uint32_t>(65535.0 * (offset / extent)));
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> keyed;
  keyed.reserve(trees.size());
  for (const std::uint32_t tree : trees) {
    const Point& point = positions[tree];
    keyed.emplace_back(cell(point.x - low.x) | (cell(point.y - low.y) << 1), tree);
  }
  std::ranges::sort(keyed);
  std::ranges::transform(keyed, trees.begin(), [](const auto& entry) { return entry.second; });
}

/// Puts runs of equal distances into their order.
void order_ties(std::vector<Neighbor>& found, const NeighborSearch::Before& before) {
  for (auto first = found.begin(); first != found.end();) {
    auto last = first + 1;
    while (last != found.end() && last->distance_m - (last - 1)->distance_m <= kSameDistance_m) {
      ++last;
    }
    if (last - first > 1) {
      std::sort(first, last, [&before](const Neighbor& a, const Neighbor& b) {
        return before(a.tree, b.tree);
      });
    }
    first = last;
  }
}

}  // namespace

struct NeighborSearch::Index {
  std::vector<std::uint32_t> trees{};
  Cloud cloud{};
  std::unique_ptr<KdTree> tree{};
};

NeighborSearch::NeighborSearch(std::vector<std::uint32_t> trees, std::span<const Point> positions)
    : index_(std::make_unique<Index>()) {
  order_in_space(trees, positions);
  index_->cloud.points.reserve(trees.size());
  for (const std::uint32_t tree : trees) index_->cloud.points.push_back(positions[tree]);
  index_->trees = std::move(trees);
  index_->tree = std::make_unique<KdTree>(2, index_->cloud);
}

NeighborSearch::~NeighborSearch() = default;
NeighborSearch::NeighborSearch(NeighborSearch&&) noexcept = default;
NeighborSearch& NeighborSearch::operator=(NeighborSearch&&) noexcept = default;

const std::vector<std::uint32_t>& NeighborSearch::trees() const { return index_->trees; }

void NeighborSearch::nearest(std::size_t position,
                             std::size_t count,
                             const Before& before,
                             std::vector<Neighbor>& found) const {
  const std::vector<Point>& points = index_->cloud.points;
  const std::array<double, 2> query{points[position].x, points[position].y};
  std::vector<std::uint32_t> indices;
  std::vector<double> squares;
  // One for the tree itself, one to see whether the last neighbor is tied with the next.
  for (std::size_t wanted = count + 2;; wanted *= 2) {
    indices.resize(wanted);
    squares.resize(wanted);
    const std::size_t got =
        index_->tree->knnSearch(query.data(), wanted, indices.data(), squares.data());
    found.clear();
    for (std::size_t i = 0; i < got; ++i) {
      if (indices[i] == position) continue;
      found.push_back({index_->trees[indices[i]], std::sqrt(squares[i])});
    }
    const bool is_all = got < wanted;
    const bool is_decided = found.size() > count &&
                            found.back().distance_m - found[count - 1].distance_m > kSameDistance_m;
    if (is_all || is_decided) break;
  }
  order_ties(found, before);
  if (found.size() > count) found.resize(count);
}

}  // namespace silvafit::stand
