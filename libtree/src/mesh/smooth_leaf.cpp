// SPDX-License-Identifier: MIT
#include "mesh/smooth_leaf.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "mesh/crown_light.hpp"
#include "mesh/leaf_surface.hpp"
#include "mesh/moving_frame.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kLeastOutline = 3;
/// An egg-shaped leaf, widest below its middle.
constexpr std::array<std::array<double, 2>, kLeastOutline> kEgg{
    {{0.72, 0.14}, {1.0, 0.42}, {0.62, 0.76}}};
/// Needles on each side of a spray.
constexpr int kNeedles = 4;

std::span<const std::array<double, 2>> outline_of(const LeafLook& look) {
  if (look.outline.empty()) return kEgg;
  return look.outline;
}

std::size_t most_points(const LeafLook& look) {
  constexpr std::size_t kCardPoints = 8;
  constexpr std::size_t kSprayPoints = 3 * kNeedles + 3;
  return std::max({kCardPoints, kSprayPoints, 2 * outline_of(look).size() + 2});
}

/// A point of a leaf: across relative to the half width, along relative to the length, and above
/// the leaf's plane relative to the half width; its position in the image.
struct Flat {
  double across = 0.0;
  double along = 0.0;
  double above = 0.0;
};

class LeafWriter {
 public:
  LeafWriter(const Crown& crown,
             const SmoothStyle& style,
             const MeshOptions& options,
             PartBuilder& build)
      : crown_(crown), style_(style), options_(options), build_(build), light_(crown) {}

  void reserve(const Skeleton& skeleton) {
    std::size_t most = 0;
    for (const LeafLook& look : style_.leaves) most = std::max(most, most_points(look));
    const std::size_t leaves =
        skeleton.leaves.size() / static_cast<std::size_t>(options_.foliage_per) + 1;
    build_.reserve(most * leaves, most * leaves);
  }

  /// \param scale  relative to the size at its site
  void add(const LeafSite& site, double scale) {
    const LeafLook& look = style_.leaves[site.grade];
    build_.reserve(most_points(look), most_points(look));
    begin(site, look, scale);
    // Without a texture a card would be a rectangle.
    const LeafForm form = options_.textured || look.form == LeafForm::kNeedleFan
                              ? look.form
                              : LeafForm::kFivePolygons;
    switch (form) {
      case LeafForm::kFivePolygons:
        return add_outline(look);
      case LeafForm::kNeedleFan:
        return add_needles();
      case LeafForm::kCard:
        return add_card();
      case LeafForm::kCrossedCards:
        add_card();
        half_width_ = length(half_width_) * facing_;
        facing_ = direction(cross(length_, half_width_));
        return add_card();
    }
  }

 private:
  void begin(const LeafSite& site, const LeafLook& look, double scale) {
    look_ = &look;
    corners_.clear();
    base_ = site.at;
    facing_ = square_to(site.along, site.facing);
    length_ = scale * site.length_m * site.along;
    half_width_ = 0.5 * look.aspect * scale * site.length_m * cross(site.along, facing_);
    // Leaves that would reach out of the crown are moved inward as a whole, as far as possible.
    const Point tip = base_ + length_;
    const Point inside = crown_.confine(tip);
    base_ = crown_.confine(base_ + (inside - tip));

    const Point middle = base_ + 0.5 * length_;
    const Point light = light_.outward(middle) + CrownLight::kAbove;
    const Point seen = dot(facing_, light) >= 0.0 ? facing_ : -1.0 * facing_;
    normal_ = direction(0.8 * seen + light, seen);
  }

  void point(Flat flat) {
    const Point at = crown_.confine(base_ + flat.along * length_ + flat.across * half_width_ +
                                    (flat.above * length(half_width_)) * facing_);
    // The halves of a folded leaf face each other a little.
    constexpr double kFold = 0.25;
    const Point sideways = direction(half_width_, facing_);
    const Point normal = direction(normal_ - (kFold * flat.across) * sideways, normal_);
    corners_.push_back({at, normal, build_.vertex(at, normal)});
    if (!options_.textured) return;
    const auto& [left, upper, right, lower] = look_->picture;
    const double u = std::clamp(0.5 + 0.5 * flat.across, 0.0, 1.0);
    const double v = std::clamp(1.0 - flat.along, 0.0, 1.0);
    const Point tangent = square_to(normal, sideways);
    // glTF's bitangent points up in the image, where v decreases.
    const float sign = dot(cross(normal, tangent), length_) >= 0.0 ? 1.0F : -1.0F;
    build_.texture({.u = left + u * (right - left),
                    .v = upper + v * (lower - upper),
                    .tangent = tangent,
                    .sign = sign});
  }

  void triangle(std::size_t a, std::size_t b, std::size_t c) {
    add_leaf_triangle(corners_[a], corners_[b], corners_[c], build_);
  }

  /// A fan from the petiole's end around the outline: the polygon with the tip, and two on each
  /// side.
  void add_outline(const LeafLook& look) {
    constexpr double kFold = 0.25;
    const auto outline = outline_of(look);
    point({});
    for (const auto& [across, along] : outline) point({across, along, kFold * across});
    point({.along = 1.0});
    for (std::size_t i = outline.size(); i-- > 0;) {
      const auto& [across, along] = outline[i];
      point({-across, along, kFold * across});
    }
    for (std::size_t i = 1; i + 1 < corners_.size(); ++i) triangle(0, i, i + 1);
  }

  /// Needles on both sides of a shoot, and one at its end.
  void add_needles() {
    constexpr double kForward = 0.3;  // relative distance between two needles' bases
    constexpr double kFold = 0.3;
    for (int i = 0; i <= kNeedles; ++i) point({.along = static_cast<double>(i) / (kNeedles + 1)});
    for (const double side : {1.0, -1.0}) {
      for (int i = 0; i < kNeedles; ++i) {
        const double along = (i + 1.0 + kForward) / (kNeedles + 1);
        const double across = side * (1.0 - 0.4 * i / kNeedles);
        point({across, along, kFold * std::abs(across)});
        const auto base = static_cast<std::size_t>(i);
        triangle(base, corners_.size() - 1, base + 1);
      }
    }
    // The end represents the last needle of each side.
    point({.across = 0.2, .along = 1.0});
    point({.across = -0.2, .along = 1.0});
    triangle(kNeedles, corners_.size() - 2, corners_.size() - 1);
  }

  void add_card() {
    corners_.clear();
    point({-1.0, 0.0, 0.0});
    point({1.0, 0.0, 0.0});
    point({1.0, 1.0, 0.0});
    point({-1.0, 1.0, 0.0});
    triangle(0, 1, 2);
    triangle(0, 2, 3);
  }

  const Crown& crown_;
  const SmoothStyle& style_;
  const MeshOptions& options_;
  PartBuilder& build_;
  CrownLight light_;

  /// Of the current leaf:
  const LeafLook* look_ = nullptr;
  Point base_{};
  Point length_{};
  Point half_width_{};
  Point facing_{};  ///< of length 1
  Point normal_{};
  std::vector<LeafCorner> corners_{};
};

}  // namespace

void check_looks(const Skeleton& skeleton, const SmoothStyle& style) {
  for (const LeafSite& site : skeleton.leaves) {
    if (site.grade < style.leaves.size()) continue;
    throw UsageError("a leaf has grade " + std::to_string(site.grade) + ", but only " +
                     std::to_string(style.leaves.size()) + " leaf types are defined");
  }
  for (const LeafLook& look : style.leaves) {
    if (!look.outline.empty() && look.outline.size() < kLeastOutline) {
      throw UsageError("a leaf outline needs at least three points per side");
    }
    if (look.texture != style.leaves.front().texture) {
      throw UsageError("all leaf types of a tree must use the same texture");
    }
  }
}

Color leaf_material(const Skeleton& skeleton, const SmoothStyle& style) {
  Color sum{};
  for (const LeafSite& site : skeleton.leaves) {
    const Color& color = style.leaves[site.grade].color;
    for (std::size_t i = 0; i < color.size(); ++i) {
      sum[i] += color[i] / static_cast<double>(skeleton.leaves.size());
    }
  }
  return sum;
}

void add_site_leaves(const Skeleton& skeleton,
                     const Limbs& limbs,
                     const Crown& crown,
                     const SmoothStyle& style,
                     const MeshOptions& options,
                     PartBuilder& build) {
  LeafWriter writer(crown, style, options, build);
  writer.reserve(skeleton);
  const double scale = std::sqrt(static_cast<double>(options.foliage_per));
  const auto step = static_cast<std::size_t>(options.foliage_per);
  for (std::size_t i = 0; i < skeleton.leaves.size(); i += step) {
    LeafSite site = skeleton.leaves[i];
    site.at = site.at + limbs.moved(site.axis, site.at);
    writer.add(site, scale);
  }
}

}  // namespace silvafit::tree
