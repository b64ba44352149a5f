// SPDX-License-Identifier: MIT
// Texture coordinates of bark on tubes, and the flare of the roots.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/preset.hpp"

namespace silvafit::tree {

/// How often the picture goes around a tube, and its repeats per meter along it. Bark keeps its
/// true size on thick wood, and is finer on branches thinner than the picture.
struct BarkScale {
  double around = 1.0;
  double per_m = 1.0;

  BarkScale(double radius_m, double picture_m) {
    const double girth = kTwoPi * radius_m;
    around = std::max(1.0, std::round(girth / picture_m));
    per_m = 0.5 * around / girth;  // the picture is twice as high as wide
  }

  /// The picture winds about the tube, so that its repeats are not one above the other.
  double u(double share_around, double along_m) const {
    constexpr double kLean = 0.2;
    return around * share_around + kLean * per_m * along_m;
  }
};

/// Colors of bark by the diameter of the wood, relative to those of the material.
class BarkPaint {
 public:
  BarkPaint(const Bark& bark, std::span<const SkeletonPoint> stem)
      : bark_(bark), material_(bark.color) {
    const auto breast =
        std::ranges::find(stem, kBreastHeight, [](const SkeletonPoint& p) { return p.at.z; });
    const double radius_m = (breast == stem.end() ? stem.front() : *breast).radius_m;
    per_radius_ = 1.0 / std::max(radius_m, 1e-6);
    if (!is_varied()) return;
    material_ = {};
    for (const Bark::Shade& shade : bark.shades) {
      for (std::size_t k = 0; k < 3; ++k) material_[k] = std::max(material_[k], shade.color[k]);
    }
  }

  double picture_m() const { return bark_.picture->width_m(); }
  bool is_varied() const { return !bark_.shades.empty(); }

  /// Gives a part its color and textures.
  void dress(MeshPart& part, bool is_textured) const {
    part.color = is_textured ? material_ : bark_.color;
    if (!is_textured) return;
    part.texture = bark_.picture->color();
    part.normal_texture = bark_.picture->normals();
  }

  Color relative(double radius_m) const {
    const double diameter = radius_m * per_radius_;
    const auto& shades = bark_.shades;
    std::size_t above = 0;
    while (above < shades.size() && shades[above].relative_diameter < diameter) ++above;
    const Bark::Shade& high = shades[std::min(above, shades.size() - 1)];
    const Bark::Shade& low = shades[above == 0 ? 0 : above - 1];
    const double range = high.relative_diameter - low.relative_diameter;
    const double share = range > 0.0 ? (diameter - low.relative_diameter) / range : 0.0;
    Color color{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = low.color[k] + share * (high.color[k] - low.color[k]);
      color[k] = value / std::max(material_[k], 1e-6);
    }
    return color;
  }

 private:
  const Bark& bark_;
  double per_radius_ = 1.0;
  Color material_;
};

/// Whether the picture ends at a seam, where a tube has two vertices at one position. Tubes of
/// three sides are so thin that it may run back on the last one.
inline bool has_seam(const std::uint32_t sides) { return sides > 3; }

/// Widening of a stem at its foot, with a lobe above each main root. It ends below breast height.
class RootFlare {
 public:
  /// Shares of its height at which the stem needs sections.
  static constexpr std::array<double, 5> kSections{0.08, 0.2, 0.38, 0.65, 1.0};
  /// The widest a section becomes, relative to the stem's without roots.
  static constexpr double kWidest = 1.65;

  /// \param radius_m  of the stem at the ground
  explicit RootFlare(double radius_m) : height_m_(std::clamp(5.0 * radius_m, 0.02, 1.1)) {}

  double height_m() const { return height_m_; }

  /// Radius relative to that without roots, in a direction around the stem.
  double at(double z_m, double angle_rad) const {
    if (z_m >= height_m_) return 1.0;
    const double low = 1.0 - std::max(z_m, 0.0) / height_m_;
    constexpr double kRoots = 4.0;
    constexpr double kRound = 0.3;
    const double lobe = 0.5 + 0.5 * std::cos(kRoots * angle_rad);
    return 1.0 + (kWidest - 1.0) * low * low * low * (kRound + (1.0 - kRound) * lobe);
  }

 private:
  double height_m_;
};

}  // namespace silvafit::tree
