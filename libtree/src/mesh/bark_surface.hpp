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
#include "silvafit/tree/texture_library.hpp"

namespace silvafit::tree {

/// How often the picture goes around a tube, and its repeats per meter along it. Bark keeps its
/// true size on thick wood, and is finer on branches thinner than the picture.
struct BarkScale {
  double around = 1.0;
  double per_m = 1.0;

  explicit BarkScale(double radius_m) {
    const double girth = kTwoPi * radius_m;
    around = std::max(1.0, std::round(girth / kBarkPictureWidth));
    per_m = around / girth;
  }
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

/// The sections of a stem with those that its roots need; the stem between them stays as it is.
template <typename Section>
std::vector<Section> with_root_sections(std::span<const Section> sections, const RootFlare& roots) {
  // Sections that floats can distinguish.
  constexpr double kNearest = 0.002;
  std::vector<Section> result;
  std::size_t next = 0;
  for (std::size_t k = 0; k + 1 < sections.size(); ++k) {
    const Section& low = sections[k];
    const Section& high = sections[k + 1];
    result.push_back(low);
    for (; next < RootFlare::kSections.size(); ++next) {
      const double z = RootFlare::kSections[next] * roots.height_m();
      if (z > high.at.z - kNearest) break;
      if (z < result.back().at.z + kNearest) continue;
      const double part = (z - low.at.z) / (high.at.z - low.at.z);
      Section section = low;
      section.at = low.at + part * (high.at - low.at);
      section.radius_m = low.radius_m + part * (high.radius_m - low.radius_m);
      if constexpr (requires { section.along_m; }) {
        section.along_m = low.along_m + part * (high.along_m - low.along_m);
      }
      result.push_back(section);
    }
  }
  result.push_back(sections.back());
  return result;
}

}  // namespace silvafit::tree
