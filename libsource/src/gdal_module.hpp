// SPDX-License-Identifier: MIT
// The functions of the module silvafit_gdal.so. The library loads it when a layer is read or
// written, because GDAL depends on about a hundred shared libraries, which would cost every start
// of the program 40 ms and 100 MB of addresses.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/source/open_raster.hpp"
#include "silvafit/source/open_table.hpp"
#include "silvafit/source/write_layers.hpp"

namespace silvafit::source {

struct GdalModule {
  /// open_table() for a name of which is_layered() holds.
  OpenedTable (*open_layer)(const std::string& name,
                            const TableChoice& choice,
                            GeometryUse use,
                            const std::optional<CoordinateSystem>& target) = nullptr;
  /// Writes layers into a new file, for which messages use another name.
  void (*write_draft)(const std::filesystem::path& draft,
                      const std::filesystem::path& file,
                      const std::vector<Layer>& layers,
                      const std::optional<CoordinateSystem>& coordinates) = nullptr;
  data::Raster (*open_raster)(const std::string& file,
                              const std::optional<CoordinateSystem>& target) = nullptr;
  std::string (*version)() = nullptr;
};

/// The name of the only function that the module exports: `const GdalModule* name()`.
inline constexpr const char* kGdalModuleFunction = "silvafit_gdal_module";

}  // namespace silvafit::source
