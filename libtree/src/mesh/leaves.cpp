// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>

#include "mesh/foliage.hpp"
#include "mesh/jitter.hpp"
#include "mesh/leaf_surface.hpp"

namespace silvafit::tree {
namespace {

class TuftGrower {
 public:
  TuftGrower(const Crown& crown,
             const Foliage& foliage,
             Random& random,
             const MeshOptions& options,
             PartBuilder& build)
      : crown_(crown),
        foliage_(foliage),
        random_(random),
        options_(options),
        surface_(crown, build) {
    // One leaf represents several: more of them in a larger crown. If only one tuft in n is drawn,
    // its leaves cover the area of n.
    constexpr double kReferenceWidth = 5.0;
    constexpr double kReferenceLength = 7.0;
    leaf_length_m_ =
        foliage.leaf_length_m *
        std::sqrt(options.foliage_per * crown.radii().width_m() * (crown.h_m() - crown.hcb_m()) /
                  (kReferenceWidth * kReferenceLength));
  }

  void add(Point end, Point along) {
    Jitter jitter(random_);
    if (tufts_++ % options_.foliage_per != options_.foliage_per / 2) return;
    const double size = leaf_length_m_ * (1.0 + 0.2 * jitter.next());
    // A tuft that would reach out of the crown is moved inward as a whole, because cut leaves would
    // look like a clipped hedge.
    const Point outward = surface_.outward_of(end);
    const double room = crown_.length_inside_m(end, outward, size);
    const Point at = end - 0.6 * (size - room) * outward;
    const Point axis =
        direction(along + 0.7 * outward + Point{0.5 * jitter.next(), 0.5 * jitter.next(), 0.35});
    const Point across =
        direction(cross(axis, {jitter.next(), jitter.next(), jitter.next()}), {1.0, 0.0, 0.0});
    place(at, size * across, size * cross(axis, across), size * axis, jitter);
  }

 private:
  void place(Point at, Point x, Point y, Point z, Jitter& jitter) {
    const Tuft& tuft = foliage_.tuft;
    surface_.begin(tuft.points.size(), tuft.leaves.size(), 0);
    for (const Point& point : tuft.points) {
      const Point lean{jitter.next(), jitter.next(), jitter.next()};
      surface_.point(at + point.x * x + point.y * y + point.z * z, kLean * lean);
    }
    for (const Tuft::Leaf& leaf : tuft.leaves) {
      surface_.leaf(leaf[0], leaf[1], leaf[2], leaf[3]);
    }
  }

  static constexpr double kLean = 0.55;

  const Crown& crown_;
  const Foliage& foliage_;
  Random& random_;
  const MeshOptions& options_;
  LeafSurface surface_;
  double leaf_length_m_ = 0.0;
  int tufts_ = 0;
};

/// Whether the next axis is a child of this one.
bool bears_another(std::span<const Axis> axes, std::size_t i) {
  return i + 1 < axes.size() && axes[i + 1].order > axes[i].order;
}

}  // namespace

void add_leaves(const Skeleton& skeleton,
                const Crown& crown,
                const Foliage& foliage,
                Random& random,
                const MeshOptions& options,
                PartBuilder& build) {
  const std::span<const Axis> axes = skeleton.axes;
  const std::size_t most = axes.size() * static_cast<std::size_t>(1 + foliage.tufts_per_shoot) /
                               static_cast<std::size_t>(options.foliage_per) +
                           1;
  const Tuft& tuft = foliage.tuft;
  build.reserve(most * tuft.points.size(), most * 2 * tuft.leaves.size());
  TuftGrower tufts(crown, foliage, random, options, build);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (axes[i].order == 0) continue;
    const auto points = skeleton.points_of(axes[i]);
    const Point tip = points.back().at;
    const Point last = tip - points[points.size() - 2].at;
    const Point along = direction(last);
    if (!bears_another(axes, i)) {
      for (int k = 0; k < foliage.tufts_per_shoot; ++k) {
        const double back = (k + 1.0) / (foliage.tufts_per_shoot + 1.0);
        tufts.add(tip - back * last, along);
      }
    }
    tufts.add(tip, along);
  }
}

}  // namespace silvafit::tree
