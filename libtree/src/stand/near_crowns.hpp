// SPDX-License-Identifier: MIT
// Crowns near each other, seen from above.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// The circle around a stem that contains the tree's crown.
struct CrownCircle {
  std::string_view plot{};
  std::string_view tree{};
  Position stem{};
  double radius_m = 0.0;
};

/// For each crown every other crown that could touch it, in increasing order.
/// \param threads  0: one for each core
/// \throws GeometryError with the tree if more crowns meet in one place than resolve_overlaps() can
///   resolve in minutes
std::vector<std::vector<std::size_t>> near_crowns(const std::vector<CrownCircle>& crowns,
                                                  unsigned threads);

}  // namespace silvafit::tree
