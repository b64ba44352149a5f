// SPDX-License-Identifier: MIT
#include "silvafit/tree/branch_library.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "segments/branch_skeleton.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

constexpr double kFirstAngle = 30.0;
constexpr double kAngleStep = 10.0;
constexpr double kLengthStep = 0.4;
constexpr double kBase = 8.0;

/// A tree whose crown is far from any branch of the library.
TreeShape roomy_tree() {
  constexpr double kRoom = 10.0;
  return {.dbh_cm = 60.0,
          .h_m = 26.0,
          .hcb_m = 0.0,
          .hc_m = 10.0,
          .radii = {kRoom, kRoom, kRoom, kRoom}};
}

/// Leaves as large as in a crown of the preset's reference size.
Preset with_leaves_of_reference(Preset preset, const TreeShape& shape) {
  constexpr double kReferenceArea = 5.0 * 7.0;
  const double area = shape.radii.width_m() * (shape.h_m - shape.hcb_m);
  preset.foliage.leaf_length_m *= std::sqrt(kReferenceArea / area);
  return preset;
}

/// Without the stem, and moved so that the branch starts at the origin.
Mesh branch_alone(Mesh mesh, Point base) {
  std::erase_if(mesh.parts, [](const MeshPart& part) { return part.kind == PartKind::kStem; });
  for (MeshPart& part : mesh.parts) {
    for (std::size_t i = 0; i < part.positions.size(); i += 3) {
      part.positions[i] -= static_cast<float>(base.x);
      part.positions[i + 1] -= static_cast<float>(base.z);
      part.positions[i + 2] += static_cast<float>(base.y);
    }
  }
  return mesh;
}

}  // namespace

Point placed(const BranchPlacement& placement, Point of_model) {
  // East is x; a larger angle from the vertical turns z towards x.
  const double cos_tilt = std::cos(placement.tilt_rad);
  const double sin_tilt = std::sin(placement.tilt_rad);
  const double out = cos_tilt * of_model.x + sin_tilt * of_model.z;
  const double up = cos_tilt * of_model.z - sin_tilt * of_model.x;
  const double sin_azimuth = std::sin(placement.azimuth_rad);
  const double cos_azimuth = std::cos(placement.azimuth_rad);
  const Point turned{sin_azimuth * out - cos_azimuth * of_model.y,
                     cos_azimuth * out + sin_azimuth * of_model.y,
                     up};
  return placement.base + placement.scale * turned;
}

BranchLibrary BranchLibrary::build(const Preset& preset,
                                   std::uint64_t seed,
                                   const MeshOptions& options) {
  const TreeShape shape = roomy_tree();
  const Crown crown(shape, {2.0, 2.0});
  Preset straight = with_leaves_of_reference(preset, shape);
  straight.branching.stem_bend = 0.0;
  BranchLibrary library;
  for (int i = 0; i < kAngles; ++i) {
    for (int k = 0; k < kLengths; ++k) {
      const double angle = kFirstAngle + kAngleStep * i;
      const double length = kLengthStep * (k + 1);
      const PlannedBranch branch{.base_m = kBase,
                                 .angle_rad = kRadian * angle,
                                 .outward = {1.0, 0.0, 0.0},
                                 .distance_m = length * std::sin(kRadian * angle)};
      Random random(seed, static_cast<std::uint64_t>(kLengths * i + k));
      const Skeleton skeleton = grow_branch_skeleton(shape, crown, straight, branch, random);
      Mesh mesh = build_mesh(skeleton, crown, straight, random, options);
      library.models_.push_back({angle, length, branch_alone(std::move(mesh), {0.0, 0.0, kBase})});
    }
  }
  return library;
}

std::size_t BranchLibrary::nearest(double angle_rad, double length_m) const {
  const auto step = [](double value, double first, double width, int count) {
    const double number = std::round((value - first) / width);
    return static_cast<std::size_t>(std::clamp(number, 0.0, count - 1.0));
  };
  return kLengths * step(angle_rad / kRadian, kFirstAngle, kAngleStep, kAngles) +
         step(length_m, kLengthStep, kLengthStep, kLengths);
}

std::vector<BranchPlacement> BranchLibrary::place(const Skeleton& skeleton) const {
  std::vector<BranchPlacement> placements;
  for (std::size_t i = 0; i < skeleton.axes.size(); ++i) {
    if (skeleton.axes[i].order != 1) continue;
    const auto points = skeleton.points_of(skeleton.axes[i]);
    const Point chord = points.back().at - points.front().at;
    const double size = length(chord);
    const double angle = std::atan2(std::hypot(chord.x, chord.y), chord.z);
    const std::size_t model = nearest(angle, size);
    placements.push_back({.model = model,
                          .axis = static_cast<std::uint32_t>(i),
                          .scale = size / models_[model].length_m,
                          .tilt_rad = angle - kRadian * models_[model].angle_deg,
                          .azimuth_rad = std::atan2(chord.x, chord.y),
                          .base = points.front().at});
  }
  return placements;
}

}  // namespace silvafit::tree
