// SPDX-License-Identifier: MIT
#include "gdal/functions.hpp"
#include "gdal_module.hpp"

extern "C" __attribute__((visibility("default"))) const silvafit::source::GdalModule*
silvafit_gdal_module() {
  static constexpr silvafit::source::GdalModule kModule{
      .open_layer = silvafit::source::open_with_gdal,
      .write_draft = silvafit::source::write_with_gdal,
      .open_raster = silvafit::source::raster_with_gdal,
      .version = silvafit::source::version_of_gdal};
  return &kModule;
}
