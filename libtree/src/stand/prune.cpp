// SPDX-License-Identifier: MIT
// A skeleton after its overlaps are resolved.
#include <algorithm>
#include <cmath>
#include <limits>

#include "fitted/fitted_leaves.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/tree/overlap.hpp"

namespace silvafit::tree {
namespace {

// A line that is cut back ends slightly before it leaves the territory, and a line with less than
// this left is removed.
constexpr double kHair = 0.98;
constexpr double kWorthKeeping = 0.3;

std::vector<SkeletonPoint> cut_back(std::span<const SkeletonPoint> line, double share) {
  const double reach = share * line_length_m(line);
  std::vector<SkeletonPoint> points{line.front()};
  double length_so_far = 0.0;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    length_so_far += length(line[i].at - line[i - 1].at);
    if (length_so_far >= reach) break;
    points.push_back(line[i]);
  }
  points.push_back({point_at(line, share).at, 0.0});
  return points;
}

class Pruner {
 public:
  Pruner(const Skeleton& skeleton, const Crown& crown, const TreeOverlap& overlap)
      : skeleton_(skeleton),
        crown_(crown),
        overlap_(overlap),
        new_axis_(skeleton.axes.size(), kNone),
        kept_share_(skeleton.axes.size(), 1.0) {
    result_.skeleton.notes = skeleton.notes;
  }

  PrunedSkeleton run() {
    for (std::uint32_t i = 0; i < skeleton_.axes.size(); ++i) {
      const Axis& axis = skeleton_.axes[i];
      const auto points = skeleton_.points_of(axis);
      if (axis.order == 0) {
        keep(i, points);
        continue;
      }
      result_.length_before_m += line_length_m(points);
      add(i, points);
    }
    restore_crown_base();
    carry_leaves();
    for (const Axis& axis : result_.skeleton.axes) {
      if (axis.order > 0) {
        result_.length_after_m += line_length_m(result_.skeleton.points_of(axis));
      }
    }
    return std::move(result_);
  }

 private:
  void add(std::uint32_t i, std::span<const SkeletonPoint> points) {
    const Axis& axis = skeleton_.axes[i];
    if (new_axis_[axis.parent] == kNone) return;
    if (std::binary_search(overlap_.removed.begin(), overlap_.removed.end(), i)) return;
    if (const BranchLine* turned = turned_course(i)) {
      keep(i, turned->points);
      return;
    }
    if (std::count(overlap_.lanes.begin(), overlap_.lanes.end(), i) > 0) {
      keep(i, points);
      return;
    }
    const std::vector<SkeletonPoint> moved = with_parent(axis, points);
    if (moved.empty()) return;
    const double held = overlap_.territory.held_share(moved);
    if (held >= 1.0) {
      keep(i, moved);
    } else if (held >= kWorthKeeping) {
      kept_share_[i] = kHair * held;
      keep(i, cut_back(moved, kHair * held));
    }
  }

  /// A twig at the new position of its branch: none if the branch was cut back before it.
  std::vector<SkeletonPoint> with_parent(const Axis& axis, std::span<const SkeletonPoint> points) {
    std::vector<SkeletonPoint> moved(points.begin(), points.end());
    if (axis.order < 2) return moved;
    const auto before = skeleton_.points_of(skeleton_.axes[axis.parent]);
    const auto now = result_.skeleton.points_of(result_.skeleton.axes[new_axis_[axis.parent]]);
    if (is_same_line(before, now)) return moved;
    const double share = nearest_share(before, points.front().at);
    const double kept = kept_share_[axis.parent];
    if (share > kept) return {};
    const Point shift = point_at(now, share / kept).at - point_at(before, share).at;
    // The remaining part of a cut line does not move, except for rounding.
    constexpr double kTouching = 1e-6;
    if (length(shift) <= kTouching) return moved;
    for (SkeletonPoint& point : moved) point.at = crown_.confine(point.at + shift);
    return moved;
  }

  const BranchLine* turned_course(std::uint32_t axis) const {
    for (const BranchLine& line : overlap_.turned) {
      if (line.axis == axis) return &line;
    }
    return nullptr;
  }

  void keep(std::uint32_t i, std::span<const SkeletonPoint> points) {
    const Axis& axis = skeleton_.axes[i];
    const std::uint32_t parent = axis.order == 0 ? 0 : new_axis_[axis.parent];
    new_axis_[i] = result_.skeleton.add_axis(axis.order, parent, points);
  }

  static double base_m(std::span<const SkeletonPoint> line) {
    double lowest = line.front().at.z;
    for (const SkeletonPoint& point : line) lowest = std::min(lowest, point.at.z);
    return lowest;
  }

  /// The lowest branch is restored, as far as the territory allows, if nothing else starts as low.
  void restore_crown_base() {
    double lowest_now = std::numeric_limits<double>::infinity();
    for (const Axis& axis : result_.skeleton.axes) {
      if (axis.order > 0) {
        lowest_now = std::min(lowest_now, base_m(result_.skeleton.points_of(axis)));
      }
    }
    constexpr double kSame = 0.001;
    std::uint32_t back = kNone;
    double most = 0.0;
    double held_of_back = 0.0;
    for (std::uint32_t i = 0; i < skeleton_.axes.size(); ++i) {
      const Axis& axis = skeleton_.axes[i];
      if (axis.order != 1 || new_axis_[i] != kNone) continue;
      const auto points = skeleton_.points_of(axis);
      if (points.front().at.z > crown_.hcb_m() + kSame) continue;
      const double held = overlap_.territory.held_share(points);
      if (held > most) {
        back = i;
        most = held;
        held_of_back = held;
      }
    }
    if (lowest_now <= crown_.hcb_m() + kSame || back == kNone) return;
    kept_share_[back] = kHair * held_of_back;
    keep(back, cut_back(skeleton_.points_of(skeleton_.axes[back]), kHair * held_of_back));
  }

  /// Leaves move with their axis; leaves of removed or cut parts are removed.
  void carry_leaves() {
    for (LeafSite leaf : skeleton_.leaves) {
      if (new_axis_[leaf.axis] == kNone || !carry(leaf)) continue;
      leaf.axis = new_axis_[leaf.axis];
      result_.skeleton.leaves.push_back(leaf);
    }
  }

  /// \return whether the leaf's axis still reaches the leaf
  bool carry(LeafSite& leaf) const {
    const auto before = skeleton_.points_of(skeleton_.axes[leaf.axis]);
    const auto now = result_.skeleton.points_of(result_.skeleton.axes[new_axis_[leaf.axis]]);
    if (is_same_line(before, now)) return true;
    const double share = nearest_share(before, leaf.at);
    if (share > kept_share_[leaf.axis]) return false;
    const double share_now = share / kept_share_[leaf.axis];
    move_with(leaf,
              along(before, share),
              along(now, share_now),
              point_at(before, share).at,
              point_at(now, share_now).at,
              1.0);
    return bring_inside(leaf, crown_);
  }

  /// Direction of a line at a relative length.
  static Point along(std::span<const SkeletonPoint> line, double share) {
    constexpr double kPiece = 0.05;
    return point_at(line, std::min(share + kPiece, 1.0)).at -
           point_at(line, std::max(share - kPiece, 0.0)).at;
  }

  const Skeleton& skeleton_;
  const Crown& crown_;
  const TreeOverlap& overlap_;
  std::vector<std::uint32_t> new_axis_;
  std::vector<double> kept_share_;  ///< of each axis's length, from its base
  PrunedSkeleton result_{};
};

/// The pieces of a part: vertices that triangles join, with one root per vertex.
std::vector<std::uint32_t> pieces_of(const MeshPart& part) {
  std::vector<std::uint32_t> root(part.vertex_count());
  for (std::uint32_t i = 0; i < root.size(); ++i) root[i] = i;
  const auto find = [&root](std::uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (std::size_t i = 0; i < part.indices.size(); i += 3) {
    const std::uint32_t a = find(part.indices[i]);
    for (std::size_t k = 1; k < 3; ++k) {
      const std::uint32_t b = find(part.indices[i + k]);
      root[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::uint32_t i = 0; i < root.size(); ++i) root[i] = find(i);
  return root;
}

Point vertex_of(const MeshPart& part, std::uint32_t i) {
  const float* at = part.positions.data() + 3 * std::size_t{i};
  return {at[0], -at[2], at[1]};
}

void move_vertex(MeshPart& part, std::uint32_t i, Point to) {
  float* at = part.positions.data() + 3 * std::size_t{i};
  at[0] = static_cast<float>(to.x) + 0.0F;
  at[1] = static_cast<float>(to.z) + 0.0F;
  at[2] = static_cast<float>(-to.y) + 0.0F;
}

/// Removes the vertices that no triangle uses.
template <typename Value>
void keep_vertices(std::vector<Value>& values,
                   const std::vector<std::uint32_t>& kept,
                   std::size_t each) {
  if (values.empty()) return;
  std::size_t to = 0;
  for (const std::uint32_t from : kept) {
    for (std::size_t k = 0; k < each; ++k) values[to++] = values[each * from + k];
  }
  values.resize(to);
}

void drop_unused(MeshPart& part) {
  std::vector<std::uint32_t> number(part.vertex_count(), kNone);
  for (const std::uint32_t index : part.indices) number[index] = 0;
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < number.size(); ++i) {
    if (number[i] == kNone) continue;
    number[i] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(i);
  }
  keep_vertices(part.positions, kept, 3);
  keep_vertices(part.normals, kept, 3);
  keep_vertices(part.colors, kept, 4);
  keep_vertices(part.uvs, kept, 2);
  keep_vertices(part.tangents, kept, 4);
  for (std::uint32_t& index : part.indices) index = number[index];
}

class FoliageTrimmer {
 public:
  FoliageTrimmer(const Territory& territory, MeshPart& part)
      : territory_(territory), part_(part), root_(pieces_of(part)) {}

  void run() {
    collect();
    std::vector<bool> is_out(part_.vertex_count(), false);
    for (auto& [root, piece] : pieces_) is_out[root] = !draw_in(piece);
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i < part_.indices.size(); i += 3) {
      if (is_out[root_[part_.indices[i]]]) continue;
      indices.insert(indices.end(),
                     part_.indices.begin() + static_cast<std::ptrdiff_t>(i),
                     part_.indices.begin() + static_cast<std::ptrdiff_t>(i + 3));
    }
    if (indices.size() == part_.indices.size()) return;
    part_.indices = std::move(indices);
    drop_unused(part_);
  }

 private:
  struct Piece {
    std::vector<std::uint32_t> vertices{};
    std::vector<std::size_t> triangles{};  ///< first index of each
  };

  void collect() {
    std::vector<std::uint32_t> slot(root_.size(), kNone);
    const auto piece_of = [&](std::uint32_t root) -> Piece& {
      if (slot[root] == kNone) {
        slot[root] = static_cast<std::uint32_t>(pieces_.size());
        pieces_.emplace_back(root, Piece{});
      }
      return pieces_[slot[root]].second;
    };
    for (std::uint32_t i = 0; i < root_.size(); ++i) piece_of(root_[i]).vertices.push_back(i);
    for (std::size_t i = 0; i < part_.indices.size(); i += 3) {
      piece_of(root_[part_.indices[i]]).triangles.push_back(i);
    }
  }

  /// Corners, middles of edges and the middle of each triangle.
  bool holds(const Piece& piece) const {
    for (const std::uint32_t i : piece.vertices) {
      if (!territory_.holds(vertex_of(part_, i))) return false;
    }
    for (const std::size_t t : piece.triangles) {
      const Point a = vertex_of(part_, part_.indices[t]);
      const Point b = vertex_of(part_, part_.indices[t + 1]);
      const Point c = vertex_of(part_, part_.indices[t + 2]);
      for (const Point at :
           {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (1.0 / 3.0) * (a + b + c)}) {
        if (!territory_.holds(at)) return false;
      }
    }
    return true;
  }

  /// Shrinks a piece towards its first vertex, where it is attached, until it fits.
  bool draw_in(const Piece& piece) {
    if (piece.triangles.empty() || holds(piece)) return true;
    const Point root = vertex_of(part_, piece.vertices.front());
    std::vector<Point> whole;
    for (const std::uint32_t i : piece.vertices) whole.push_back(vertex_of(part_, i));
    for (const double share : {0.8, 0.6, 0.4}) {
      for (std::size_t k = 0; k < whole.size(); ++k) {
        move_vertex(part_, piece.vertices[k], root + share * (whole[k] - root));
      }
      if (holds(piece)) return true;
    }
    return false;
  }

  const Territory& territory_;
  MeshPart& part_;
  std::vector<std::uint32_t> root_;
  std::vector<std::pair<std::uint32_t, Piece>> pieces_{};
};

}  // namespace

PrunedSkeleton prune(const Skeleton& skeleton, const Crown& crown, const TreeOverlap& overlap) {
  return Pruner(skeleton, crown, overlap).run();
}

void keep_within(const Territory& territory, Mesh& mesh) {
  if (territory.is_alone()) return;
  for (MeshPart& part : mesh.parts) {
    if (part.kind == PartKind::kFoliage) FoliageTrimmer(territory, part).run();
  }
  mesh.parts.erase(std::remove_if(mesh.parts.begin(),
                                  mesh.parts.end(),
                                  [](const MeshPart& part) { return part.indices.empty(); }),
                   mesh.parts.end());
}

}  // namespace silvafit::tree
