// SPDX-License-Identifier: MIT
// The data of a 3D page as docs/view.md describes them.
#pragma once

#include <string>
#include <string_view>

#include "silvafit/study/view_data.hpp"
#include "silvafit/tree/builder.hpp"
#include "view/view_models.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {

/// Base64 with padding. Source: RFC 4648, section 4.
std::string base64(std::string_view bytes);

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
