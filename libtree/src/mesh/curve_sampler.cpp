// SPDX-License-Identifier: MIT
#include "mesh/curve_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "mesh/moving_frame.hpp"

namespace silvafit::tree {
namespace {

/// The distance of the corners of a triangle with the circle's area.
constexpr double kFarthestCorner = 1.56;

/// Limits the tilt of stem sections so that they do not cross breast height.
void limit_lean(Ring& ring) {
  constexpr double kShare = 0.5;
  const Point up{0.0, 0.0, 1.0};
  const double above = ring.at.z - kBreastHeight;
  if (above <= 0.0) return ring.turn(up, ring.sideways);
  const double steepest = std::min(kShare * above / (kFarthestCorner * ring.radius_m), 1.0);
  const Point flat{ring.tangent.x, ring.tangent.y, 0.0};
  if (length(flat) <= steepest && ring.tangent.z > 0.0) return;
  if (ring.tangent.z < 0.0 && steepest == 1.0) return;
  const Point leaning = steepest * direction(flat, up) + std::sqrt(1.0 - steepest * steepest) * up;
  ring.turn(direction(leaning), ring.sideways);
}

}  // namespace

Ring CurveSampler::ring_at(double along_m) {
  while (piece_ + 1 < pieces_.size() && along_m > ends_[piece_]) ++piece_;
  const HermitePiece& piece = pieces_[piece_];
  const double beyond_m = along_m - (ends_[piece_] - piece.length_m());
  const double share = piece.share_at(beyond_m);
  Ring ring;
  ring.at = piece.at(share);
  ring.radius_m = piece.radius_m(std::clamp(beyond_m / piece.length_m(), 0.0, 1.0));
  ring.tangent = direction(piece.rate(share));
  ring.along_m = along_m;
  return ring;
}

/// Equal steps up to `to_m`, without the first point.
void CurveSampler::add_steps(double from_m, double to_m, std::vector<Ring>& samples) {
  const auto steps = static_cast<std::size_t>(std::ceil((to_m - from_m) / step_m_));
  for (std::size_t i = 1; i <= steps; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(steps);
    samples.push_back(ring_at(i == steps ? to_m : from_m + share * (to_m - from_m)));
  }
}

/// One more if there is none near.
void CurveSampler::insert(double along_m, std::vector<Ring>& samples) {
  const auto after =
      std::lower_bound(samples.begin(), samples.end(), along_m, [](const Ring& ring, double along) {
        return ring.along_m < along;
      });
  if (after == samples.begin() || after == samples.end()) return;
  const auto before = after - 1;
  const double near = 0.2 * (after->along_m - before->along_m);
  if (before != samples.begin() && along_m - before->along_m < near) {
    before->is_fixed = true;
  } else if (after + 1 != samples.end() && after->along_m - along_m < near) {
    after->is_fixed = true;
  } else {
    piece_ = 0;
    Ring ring = ring_at(along_m);
    ring.is_fixed = true;
    samples.insert(after, ring);
  }
}

void CurveSampler::begin(std::span<const HermitePiece> pieces, const Limb& limb) {
  pieces_ = pieces;
  piece_ = 0;
  breast_height_m_ = 0.0;
  ends_.clear();
  double whole = 0.0;
  for (const HermitePiece& piece : pieces) {
    whole += piece.length_m();
    ends_.push_back(whole);
    // A cubic ends at its knot except for rounding.
    constexpr double kRounding = 1e-12;
    if (limb.axis == 0 && piece.at(1.0).z <= kBreastHeight + kRounding) breast_height_m_ = whole;
  }
}

void CurveSampler::sample(std::span<const HermitePiece> pieces,
                          const Limb& limb,
                          double tolerance_m,
                          std::vector<Ring>& samples) {
  constexpr double kMostStepsPerPiece = 24.0;
  begin(pieces, limb);
  double per_meter = 0.0;
  for (const HermitePiece& piece : pieces) {
    const double steps = std::min(piece.steps_within(tolerance_m), kMostStepsPerPiece);
    if (piece.length_m() > 0.0) per_meter = std::max(per_meter, steps / piece.length_m());
  }
  const double most = kMostStepsPerPiece * static_cast<double>(pieces.size());
  step_m_ = ends_.back() / std::clamp(per_meter * ends_.back(), 1.0, most);
  add_samples(limb, samples);
}

void CurveSampler::sample_evenly(std::span<const HermitePiece> pieces,
                                 const Limb& limb,
                                 double step_m,
                                 std::vector<Ring>& samples) {
  begin(pieces, limb);
  step_m_ = step_m;
  add_samples(limb, samples);
}

void CurveSampler::add_samples(const Limb& limb, std::vector<Ring>& samples) {
  const double whole = ends_.back();
  samples.clear();
  samples.push_back(ring_at(0.0));
  if (breast_height_m_ > 0.0 && breast_height_m_ < whole) {
    add_steps(0.0, breast_height_m_, samples);
    samples.back().at.z = kBreastHeight;
    samples.back().is_fixed = true;
    add_steps(breast_height_m_, whole, samples);
  } else {
    add_steps(0.0, whole, samples);
  }
  if (limb.collar_m > 0.0) insert(limb.collar_m, samples);
  // A blunt end is rounded.
  constexpr double kBlunt = 0.0001;
  if (limb.axis != 0 && samples.back().radius_m > kBlunt) {
    insert(whole - std::min(samples.back().radius_m, 0.5 * whole), samples);
  }

  Ring& base = samples.front();
  const bool is_stem = limb.axis == 0;
  const Point level = direction(cross({0.0, 0.0, 1.0}, base.tangent), {1.0, 0.0, 0.0});
  base.turn(base.tangent, is_stem ? Point{1.0, 0.0, 0.0} : level);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const Ring& before = samples[i - 1];
    Ring& ring = samples[i];
    ring.sideways = carried_on(before.at, before.tangent, before.sideways, ring.at, ring.tangent);
    ring.upward = cross(ring.tangent, ring.sideways);
  }
  if (is_stem) std::for_each(samples.begin(), samples.end(), limit_lean);
}

}  // namespace silvafit::tree
