// SPDX-License-Identifier: MIT
#include "stand/dead_wood.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

/// Of a snag; 1 if it was not recorded.
std::size_t decay_class_of(const Morphology& morphology) {
  return static_cast<std::size_t>(morphology.decay_class.value_or(1.0));
}

/// A stem up to a height, where its section is closed by a cone.
std::vector<SkeletonPoint> lower_part(std::span<const SkeletonPoint> stem,
                                      double top_m,
                                      double cone_m) {
  const SkeletonPoint end = at_height(stem, top_m - cone_m);
  std::vector<SkeletonPoint> part;
  for (const SkeletonPoint& point : stem) {
    if (point.at.z < end.at.z) part.push_back(point);
  }
  part.push_back(end);
  part.push_back({{end.at.x, end.at.y, top_m}, 0.0});
  return part;
}

std::vector<SkeletonPoint> remaining_stem(const Morphology& morphology,
                                          std::span<const SkeletonPoint> stem) {
  // A saw leaves a flat face; rings closer than 2 mm to the tip are not drawn.
  constexpr double kSawn = 0.002;
  if (morphology.remains == Remains::kStump) return lower_part(stem, kStumpHeight, kSawn);
  if (morphology.remains == Remains::kLog) {
    // Bends of the crown would lift the log off the ground.
    std::vector<SkeletonPoint> straight(stem.begin(), stem.end());
    for (SkeletonPoint& point : straight) point.at = {0.0, 0.0, point.at.z};
    return straight;
  }
  if (decay_class_of(morphology) == 1) return {stem.begin(), stem.end()};
  // Splinters as long as the stem is thick, above the section whose diameter is measured.
  const double splinters = std::min(2.0 * at_height(stem, morphology.h_m).radius_m,
                                    0.5 * (morphology.h_m - kBreastHeight));
  return lower_part(stem, morphology.h_m, splinters);
}

/// The points of a branch of a snag that are left; none if the branch is gone.
std::span<const SkeletonPoint> remaining_branch(const Axis& axis,
                                                std::size_t number,
                                                std::size_t decay_class,
                                                std::span<const SkeletonPoint> line) {
  if (decay_class == 1) return line;
  if (axis.order > 1 || decay_class > 3) return {};
  constexpr std::size_t kFew = 3;  // one branch of this number
  if (number % kFew != 0) return {};
  return line;
}

}  // namespace

void stand_before_breaking(const Morphology& morphology, TreeShape& shape) {
  if (morphology.remains != Remains::kSnag) return;
  if (!morphology.decay_class) {
    shape.notes.push_back({"decay", "decay class not recorded: drawn with all branches (class 1)"});
  }
  // FIA's classes tell that a top is broken, not how much is gone: less of older snags is left.
  constexpr std::array<double, 5> kLeft{1.0, 0.9, 0.7, 0.5, 0.4};
  const double left = kLeft[decay_class_of(morphology) - 1];
  if (left == 1.0) return;
  shape.h_m /= left;
  shape.notes.push_back(
      {"broken_top",
       fmt::format("height before the top broke not known: the snag is drawn as the lower {} of it",
                   left)});
}

Skeleton remains_of(const Morphology& morphology, const Skeleton& skeleton) {
  Skeleton left;
  left.add_axis(0, 0, remaining_stem(morphology, skeleton.points_of(skeleton.axes.front())));
  if (morphology.remains != Remains::kSnag) return left;
  const std::size_t decay_class = decay_class_of(morphology);
  std::vector<std::uint32_t> number(skeleton.axes.size(), kNone);
  number.front() = 0;
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) {
    const Axis& axis = skeleton.axes[i];
    if (number[axis.parent] == kNone) continue;
    const auto line = remaining_branch(axis, i, decay_class, skeleton.points_of(axis));
    const auto is_above = [&](const SkeletonPoint& point) {
      return point.at.z + point.radius_m > morphology.h_m;
    };
    // A whole top's branches are inside the crown, whose height is the measured one.
    const bool is_broken_off = decay_class > 1 && std::ranges::any_of(line, is_above);
    if (line.empty() || is_broken_off) continue;
    if (decay_class < 3) {
      number[i] = left.add_axis(axis.order, number[axis.parent], line);
      continue;
    }
    constexpr double kStub_m = 0.25;  // from the bark
    const double stem_radius =
        at_height(skeleton.points_of(skeleton.axes.front()), line.front().at.z).radius_m;
    const double share = (stem_radius + kStub_m) / line_length_m(line);
    if (share >= 1.0) continue;
    left.add_axis(1, 0);
    left.add_point(line.front().at, line.front().radius_m);
    left.add_point(point_at(line, share).at, 0.0);
  }
  return left;
}

void lay_down(Mesh& mesh, Random& random) {
  const double azimuth = random.uniform(0.0, kTwoPi);
  const float east = static_cast<float>(std::cos(azimuth));
  const float south = static_cast<float>(std::sin(azimuth));
  // Up becomes the direction of the fall, and that direction down.
  const auto turn = [east, south](std::vector<float>& vectors, std::size_t size) {
    for (std::size_t i = 0; i + 2 < vectors.size(); i += size) {
      const float along = vectors[i] * east + vectors[i + 2] * south;
      const float across = vectors[i + 2] * east - vectors[i] * south;
      const float up = vectors[i + 1];
      vectors[i] = up * east - across * south;
      vectors[i + 1] = -along;
      vectors[i + 2] = up * south + across * east;
    }
  };
  float lowest = 0.0F;
  for (MeshPart& part : mesh.parts) {
    turn(part.positions, 3);
    turn(part.normals, 3);
    turn(part.tangents, 4);
    for (std::size_t i = 1; i < part.positions.size(); i += 3) {
      lowest = std::min(lowest, part.positions[i]);
    }
  }
  for (MeshPart& part : mesh.parts) {
    for (std::size_t i = 1; i < part.positions.size(); i += 3) part.positions[i] -= lowest;
  }
}

}  // namespace silvafit::tree
