// SPDX-License-Identifier: MIT
// The functions of the module, as GdalModule describes them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/source/open_raster.hpp"
#include "silvafit/source/open_table.hpp"
#include "silvafit/source/write_layers.hpp"

namespace silvafit::source {

OpenedTable open_with_gdal(const std::string& name,
                           const TableChoice& choice,
                           GeometryUse use,
                           const std::optional<CoordinateSystem>& target);

void write_with_gdal(const std::filesystem::path& draft,
                     const std::filesystem::path& file,
                     const std::vector<Layer>& layers,
                     const std::optional<CoordinateSystem>& coordinates);

data::Raster raster_with_gdal(const std::string& file,
                              const std::optional<CoordinateSystem>& target);

std::string version_of_gdal();

}  // namespace silvafit::source
