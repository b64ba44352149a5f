// SPDX-License-Identifier: MIT
// Single leaves, sprays and cards at the leaf sites of a skeleton.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "mesh/crown_light.hpp"
#include "mesh/leaf_surface.hpp"
#include "mesh/part_builder.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// \throws UsageError as build_smooth_mesh()
void check_looks(const Skeleton& skeleton, const SmoothStyle& style);

/// Mean color of the leaves.
Color leaf_material(const Skeleton& skeleton, const SmoothStyle& style);

/// Adds leaves to a part. All their vertices are inside the crown.
class LeafWriter {
 public:
  LeafWriter(const Crown& crown,
             const SmoothStyle& style,
             const MeshOptions& options,
             PartBuilder& build);

  void reserve(const Skeleton& skeleton);

  /// \param scale  relative to the size at its site
  void add(const LeafSite& site, double scale);

 private:
  /// A point of a leaf: across relative to the half width, along relative to the length, and
  /// above the leaf's plane relative to the half width; its position in the image.
  struct Flat {
    double across = 0.0;
    double along = 0.0;
    double above = 0.0;
  };

  void begin(const LeafSite& site, const LeafLook& look, double scale);
  void point(Flat flat);
  void triangle(std::size_t a, std::size_t b, std::size_t c);
  void add_outline(const LeafLook& look);
  void add_needles();
  void add_card();

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
  std::vector<LeafCorner> corners_;
};

}  // namespace silvafit::tree
