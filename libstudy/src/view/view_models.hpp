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

struct ViewModels {
  tree::SharedModels shared{};  ///< the page adapts a model's shape to each tree
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
