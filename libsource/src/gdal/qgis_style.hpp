// SPDX-License-Identifier: MIT
// Styles of layers for QGIS.
#pragma once

#include <string>

#include "silvafit/source/write_layers.hpp"

namespace silvafit::source {

/// A style in QGIS's XML (QML); empty for LayerStyle::kNone.
std::string qgis_style(const Layer& layer);

}  // namespace silvafit::source
