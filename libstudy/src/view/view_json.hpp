// SPDX-License-Identifier: MIT
// The data of a 3D page as docs/view.md describes them.
#pragma once

#include <string>

#include "silvafit/study/view_data.hpp"
#include "silvafit/tree/builder.hpp"
#include "view/view_models.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {

/// The objects that the page draws.
struct ViewDrawing {
  tree::Position origin{};
  const ViewModels* models = nullptr;  ///< of all trees of all variants that have a shape
  std::string scene{};                 ///< GLB, instead of models
};

std::string view_json(const ViewStand& stand,
                      const ViewDrawing& drawing,
                      const ViewOptions& options);

}  // namespace silvafit::study
