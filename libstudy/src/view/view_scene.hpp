// SPDX-License-Identifier: MIT
// Finds the nodes of trees in a GLB scene.
#pragma once

#include <cstddef>
#include <string_view>

#include "silvafit/data/table.hpp"
#include "silvafit/study/view_data.hpp"
#include "silvafit/tree/builder.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {

struct SceneTrees {
  ViewStand stand{};
  tree::Position origin{};     ///< of the scene's frame in the inventory's coordinates
  std::size_t unmeasured = 0;  ///< trees of a scene without any measurements
};

/// \throws as view_of_scene()
SceneTrees trees_of_scene(std::string_view glb,
                          const data::Table* table,
                          const tree::BuilderCatalogue& catalogue,
                          const ViewOptions& options);

}  // namespace silvafit::study
