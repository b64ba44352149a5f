// SPDX-License-Identifier: MIT
// The models that the trees of a 3D page share: the only place where the page has trees grown.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "silvafit/study/view_data.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/shared_models.hpp"

namespace silvafit::study {

/// A model's shape, which the page bends into that of each tree.
struct ViewModel {
  std::string preset{};
  double h_m = 0.0;
  double hcb_m = 0.0;
  double hc_m = 0.0;
  tree::CrownRadii radii{};
};

struct ViewModels {
  std::vector<ViewModel> models{};
  std::vector<std::size_t> of_tree{};
  /// By how much a tree's stem is thicker than its model's once heights are bent: DBH by the
  /// diameter of the model's stem where 1.3 m of the tree lie.
  std::vector<double> girth{};
  /// GLB: a node `model-M-level-L` for each model and level, and `ground`; packed by meshoptimizer.
  std::string glb{};
};

/// \param trees    of all variants
/// \param presets  one a tree
/// \param stems    places of the stems, through which the ground passes
/// \param origin   of the frame in which the ground lies
ViewModels grow_view_models(std::span<const tree::Morphology> trees,
                            std::span<const tree::Preset* const> presets,
                            std::span<const tree::Position> stems,
                            const tree::Position& origin,
                            const ViewOptions& options);

/// The height on a model's stem that comes to lie at a height of the tree when the parts below the
/// crown base, up to the widest crown, and above are each stretched by themselves.
double height_on_model_m(double height_m, const ViewModel& model, const tree::TreeShape& tree);

}  // namespace silvafit::study
