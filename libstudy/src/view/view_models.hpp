// SPDX-License-Identifier: MIT
// The models that the trees of a 3D page share: only this file grows trees for the page.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "silvafit/study/view_data.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/shared_models.hpp"

namespace silvafit::study {

/// A model's shape, which the page adapts to each tree.
struct ViewModel {
  std::string preset{};
  double h_m = 0.0;
  double hcb_m = 0.0;
  double hc_m = 0.0;
  double dbh_cm = 0.0;
  tree::CrownRadii radii{};
};

struct ViewModels {
  std::vector<ViewModel> models{};
  std::vector<std::size_t> of_tree{};
  /// GLB: a node `model-M-level-L` for each model and level, and `ground`; compressed by
  /// meshoptimizer.
  std::string glb{};
};

/// \param trees    of all variants
/// \param presets  one per tree
/// \param stems    positions of the stems, through which the ground passes
/// \param origin   of the frame of the ground
ViewModels grow_view_models(std::span<const tree::Morphology> trees,
                            std::span<const tree::Builder* const> presets,
                            std::span<const tree::Position> stems,
                            const tree::Position& origin,
                            const ViewOptions& options);

}  // namespace silvafit::study
