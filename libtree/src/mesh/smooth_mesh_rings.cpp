// SPDX-License-Identifier: MIT
#include "mesh/smooth_mesh_rings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/level_of_detail.hpp"
#include "mesh/line_simplification.hpp"
#include "mesh/moving_frame.hpp"
#include "mesh/segment_tubes.hpp"
#include "mesh/tube.hpp"

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

namespace {

/// Part of a tolerance for straight lines between a curve's steps; the rest is for omitted
/// steps.
constexpr double kStepShare = 0.4;

/// Anything thinner or shorter cannot be represented by floats at a height.
double least_distance_m(double height_m) { return 0.0002 * (1.0 + 0.05 * std::abs(height_m)); }

/// By default, bends may add half as much to the surface's error as the section's
/// corners.
double own_tolerance_m(double radius_m, int sides) {
  constexpr double kFinest = 0.0002;
  return std::max(0.5 * (equal_area_corner(sides) - 1.0) * radius_m, kFinest);
}

double tolerance_of(const Limb& limb, double radius_m, int sides, const MeshOptions& options) {
  double wanted = limb.axis == 0 ? stem_tolerance_m(options) : branch_tolerance_m(options);
  if (options.textured && limb.axis != 0) {
    // Bends of twigs are hidden by their leaves, small ones of thick limbs by their bark.
    constexpr double kOfTwig = 0.03;
    constexpr double kOfRadius = 0.3;
    const bool is_twig = 2.0 * radius_m < options.thick_branch_m;
    wanted = std::max(wanted, is_twig ? kOfTwig : kOfRadius * radius_m);
  }
  return wanted > 0.0 ? wanted : own_tolerance_m(radius_m, sides);
}

int sides_with(const Limb& limb, double radius_m, const MeshOptions& options) {
  if (limb.axis == 0) return options.stem_sides;
  return 2.0 * radius_m >= options.thick_branch_m ? options.branch_sides : options.twig_sides;
}

/// Error of the tube at a ring that is omitted between two others: its center, its radius, and its
/// corners as the curve turns.
struct RingError {
  double bend = 1.0;  ///< weight of the center's error

  double operator()(const Ring& a, const Ring& b, const Ring& ring) const {
    const auto [middle, sideways, upward] = offset_between(a, b, ring);
    return bend * length(middle) +
           std::sqrt(std::max(dot(sideways, sideways), dot(upward, upward)));
  }
};

/// Whether all corners of a ring are ahead of another's, as seen from both.
bool advances(const Ring& from, const Ring& to, std::span<const Point> corners, double least_m) {
  return std::all_of(corners.begin(), corners.end(), [&](const Point& corner) {
    const Point step =
        to.at + to.radius_m * to.across(corner) - (from.at + from.radius_m * from.across(corner));
    return dot(step, from.tangent) > least_m && dot(step, to.tangent) > least_m;
  });
}

bool reaches(const Ring& from, const Ring& tip, std::span<const Point> corners, double least_m) {
  return std::all_of(corners.begin(), corners.end(), [&](const Point& corner) {
    return dot(tip.at - (from.at + from.radius_m * from.across(corner)), from.tangent) > least_m;
  });
}

}  // namespace

WoodRings::WoodRings(const Limbs& limbs,
                     const Crown& crown,
                     const MeshOptions& options,
                     double step_m)
    : limbs_(limbs),
      crown_(crown),
      options_(options),
      step_m_(step_m),
      branch_corners_(equal_area_corners(options.branch_sides)),
      twig_corners_(equal_area_corners(options.twig_sides)) {
  first_.reserve(limbs.all().size() + 1);
  first_.push_back(0);
  for (const Limb& limb : limbs.all()) {
    add(limb);
    first_.push_back(rings_.size());
  }
}

int WoodRings::sides_of(const Limb& limb) const {
  return sides_with(limb, limbs_.knots_of(limb).front().radius_m, options_);
}

std::span<const Point> WoodRings::corners_of(const Limb& limb) const {
  return sides_of(limb) == options_.branch_sides ? branch_corners_ : twig_corners_;
}

bool WoodRings::is_omitted(const Limb& limb, double thinnest_m) const {
  const bool is_thin = 2.0 * limbs_.knots_of(limb).front().radius_m < thinnest_m;
  return is_thin && limbs_.drawn_knots(limb, 0) == 0;
}

void WoodRings::omit_thinner(double diameter_m) {
  std::vector<bool> is_kept(rings_.size(), true);
  for (std::size_t i = 0; i < limbs_.all().size(); ++i) {
    if (!is_omitted(limbs_.all()[i], diameter_m)) continue;
    for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) is_kept[k] = false;
  }
  keep_rings(is_kept);
}

void WoodRings::straighten_thinner(double diameter_m) {
  std::vector<bool> is_kept(rings_.size(), true);
  for (std::size_t i = 0; i < limbs_.all().size(); ++i) {
    if (!is_omitted(limbs_.all()[i], diameter_m)) continue;
    for (std::size_t k = first_[i] + 1; k + 1 < first_[i + 1]; ++k) is_kept[k] = false;
  }
  keep_rings(is_kept);
  for (std::size_t i = 0; i < limbs_.all().size(); ++i) {
    const Limb& limb = limbs_.all()[i];
    if (of(i).size() < 2 || !is_omitted(limb, diameter_m)) continue;
    Ring& base = rings_[first_[i]];
    const Ring& tip = rings_[first_[i + 1] - 1];
    if (limb.bearer != kNone) place_base(limb, base);
    base.turn(direction(tip.at - base.at, base.tangent), base.sideways);
    fit_base_into_crown(limb, corners_of(limb), base);
  }
}

void WoodRings::keep_rings(const std::vector<bool>& is_kept) {
  std::size_t kept = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < limbs_.all().size(); ++i) {
    const std::size_t end = first_[i + 1];
    for (; begin < end; ++begin) {
      if (is_kept[begin]) rings_[kept++] = rings_[begin];
    }
    first_[i + 1] = kept;
  }
  rings_.resize(kept);
}

void WoodRings::add(const Limb& limb) {
  const std::size_t drawn = limbs_.drawn_knots(limb, options_.wood_order);
  if (drawn < 2) return;
  if (options_.textured && is_omitted(limb, options_.thinnest_wood_m)) return;
  take_steps(limb, drawn);
  const bool is_stem = limb.axis == 0;
  if (is_stem) {
    constexpr double kThinnest = 0.00005;
    constexpr double kNearest = 0.001;
    const Ring tip = kept_.back();
    std::erase_if(kept_, [&](const Ring& ring) {
      const bool is_tip = ring.along_m == tip.along_m;
      const bool is_like_tip = ring.radius_m < kThinnest || tip.at.z - ring.at.z < kNearest;
      return !is_tip && !ring.is_fixed && ring.along_m > 0.0 && is_like_tip;
    });
    kept_.back().radius_m = 0.0;
  } else {
    const std::span<const Point> corners = corners_of(limb);
    if (limb.bearer != kNone) place_base(limb, kept_.front());
    // Up to its collar the tube widens linearly.
    const double widest = collar_radius_m(limb);
    for (Ring& ring : kept_) {
      if (ring.along_m >= limb.collar_m) break;
      const double share = ring.along_m / limb.collar_m;
      const double base = kept_.front().radius_m;
      ring.radius_m = std::min(ring.radius_m, base + share * (widest - base));
    }
    fit_base_into_crown(limb, corners, kept_.front());
    for (std::size_t i = 1; i + 1 < kept_.size(); ++i) fit_into_crown(kept_[i], corners);
    keep_advancing(limb, corners);
    if (kept_.size() < 2) return;
  }
  rings_.insert(rings_.end(), kept_.begin(), kept_.end());
}

double WoodRings::collar_radius_m(const Limb& limb) const {
  for (const Ring& ring : kept_) {
    if (ring.along_m >= limb.collar_m) return ring.radius_m;
  }
  return kept_.back().radius_m;
}

/// Fills kept_ with the drawn steps of the curve.
void WoodRings::take_steps(const Limb& limb, std::size_t drawn_knots) {
  const auto pieces = limbs_.pieces_of(limb).first(drawn_knots - 1);
  if (step_m_ > 0.0) {
    sampler_.sample_evenly(pieces, limb, step_m_, kept_);
    return;
  }
  const double radius = limbs_.knots_of(limb).front().radius_m;
  const MeshOptions finest{};
  const double tolerance = tolerance_of(limb, radius, sides_of(limb), options_);
  // All levels of detail choose from the same steps.
  const double of_finest = tolerance_of(limb, radius, sides_with(limb, radius, finest), finest);
  sampler_.sample(pieces, limb, kStepShare * std::min(tolerance, of_finest), samples_);
  // Its axis may shift more below the relief of bark; its diameters may not.
  const double stem_bend = options_.textured ? 3.0 * kBendTolerance : kBendTolerance;
  const double bend = limb.axis == 0 ? 1.0 / stem_bend : 1.0;
  const auto is_fixed = [](const Ring& ring) { return ring.is_fixed; };
  const std::span<const Ring> samples = samples_;
  take_marked(samples,
              needed_of(samples, (1.0 - kStepShare) * tolerance, RingError{.bend = bend}, is_fixed),
              kept_);
}

/// Moves the base onto the drawn parent, and makes it small enough to be inside.
void WoodRings::place_base(const Limb& limb, Ring& base) const {
  const auto rings = of(limb.bearer);
  if (rings.size() < 2) return;
  const auto at = [&](double along_m) {
    auto after =
        std::upper_bound(rings.begin(), rings.end(), along_m, [](double along, const Ring& ring) {
          return along < ring.along_m;
        });
    after = std::clamp(after, rings.begin() + 1, rings.end() - 1);
    const Ring& a = *(after - 1);
    const Ring& b = *after;
    const double part =
        std::clamp((along_m - a.along_m) / std::max(b.along_m - a.along_m, 1e-12), 0.0, 1.0);
    return between({a.at, a.radius_m}, {b.at, b.radius_m}, part);
  };
  const Limb& bearer = limbs_.all()[limb.bearer];
  const int bearer_sides = sides_of(bearer);
  const double inner = equal_area_corner(bearer_sides) * std::cos(std::numbers::pi / bearer_sides);
  const double corner = equal_area_corner(sides_of(limb));
  const SkeletonPoint place = at(limb.bearer_along_m);
  const double reach = corner * base.radius_m;
  const double thinnest = std::min({place.radius_m,
                                    at(limb.bearer_along_m - reach).radius_m,
                                    at(limb.bearer_along_m + reach).radius_m});
  constexpr double kInside = 0.8;
  constexpr double kThinnest = 0.0001;
  base.at = place.at;
  base.radius_m = std::max(std::min(base.radius_m, kInside * inner * thinnest / corner), kThinnest);
}

/// A base inside a branch is not moved, because the branch has been fitted itself; it is
/// moved only if the crown is concave, so that the straight line between two fitted rings
/// leaves it.
void WoodRings::fit_base_into_crown(const Limb& limb,
                                    std::span<const Point> corners,
                                    Ring& base) const {
  constexpr double kLetPass = 0.0005;
  const bool is_on_branch = limb.bearer != kNone && limbs_.all()[limb.bearer].axis != 0;
  const bool stays =
      is_on_branch && std::all_of(corners.begin(), corners.end(), [&](const Point& corner) {
        return crown_.excess_m(base.at + base.radius_m * base.across(corner)) < kLetPass;
      });
  if (!stays) fit_into_crown(base, corners);
}

/// A tolerance of half a millimeter, so that a ring never becomes a point.
void WoodRings::fit_into_crown(Ring& ring, std::span<const Point> corners) const {
  constexpr double kLetPass = 0.0003;
  ring.radius_m = std::max(ring.radius_m, kLetPass);
  const RingInCrown in_crown(crown_, corners, ring.sideways, ring.upward);
  in_crown.fit(ring.at, ring.radius_m, kLetPass);
}

/// Omits rings that would fold the tube if a curve turns more sharply than it is thick, or that
/// floats cannot distinguish. Of a limb that is too short only the tip is left.
void WoodRings::keep_advancing(const Limb& limb, std::span<const Point> corners) {
  const Ring tip = kept_.back();
  const double least = least_distance_m(tip.at.z);
  const Point whole = tip.at - kept_.front().at;
  if (length(whole) <= 2.0 * least) {
    kept_.assign(1, tip);
    return;
  }
  std::size_t kept = 1;
  for (std::size_t i = 1; i + 1 < kept_.size(); ++i) {
    if (advances(kept_[kept - 1], kept_[i], corners, least)) kept_[kept++] = kept_[i];
  }
  while (kept > 1 && !reaches(kept_[kept - 1], tip, corners, least)) --kept;
  Ring& base = kept_.front();
  // A hook that returns behind its base becomes straight.
  if (kept == 1 && !reaches(base, tip, corners, least)) {
    base.turn(direction(whole), base.sideways);
    fit_base_into_crown(limb, corners, kept_.front());
  }
  kept_[kept++] = tip;
  kept_.resize(kept);
}

}  // namespace silvafit::tree
