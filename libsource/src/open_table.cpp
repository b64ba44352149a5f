// SPDX-License-Identifier: MIT
// CSV files and workbooks are read and written without GDAL; its module is loaded when another
// source needs it.
#include "silvafit/source/open_table.hpp"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "gdal_module.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/module_function.hpp"
#include "silvafit/source/write_layers.hpp"
#include "source_kind.hpp"
#include "workbook/read_workbook.hpp"
#include "workbook/write_workbook.hpp"

namespace silvafit::source {
namespace {

/// The module, or the reason why it is missing.
struct LoadedModule {
  const GdalModule* functions = nullptr;
  std::string problem{};
};

LoadedModule load_module() {
  const auto loaded = module_function("silvafit_gdal", kGdalModuleFunction, false);
  if (!loaded) {
    return {.problem =
                "this silvafit was built without GDAL; install libgdal-dev and build it with make "
                "build, or use CSV or .xlsx"};
  }
  if (loaded->address == nullptr) {
    return {.problem =
                fmt::format("GDAL cannot be loaded ({}); install libgdal32, or use CSV or .xlsx",
                            loaded->problem)};
  }
  return {.functions = reinterpret_cast<const GdalModule* (*)()>(loaded->address)()};
}

const LoadedModule& module() {
  static const LoadedModule loaded = load_module();
  return loaded;
}

}  // namespace

OpenedTable open_table(const std::string& name,
                       const TableChoice& choice,
                       GeometryUse use,
                       const std::optional<CoordinateSystem>& target) {
  const SourceKind* const kind = kind_of_source(name);
  if (kind == nullptr) {
    if (!choice.layer.empty() || !choice.sql.empty()) {
      throw UsageError("a CSV file has no layers",
                       {.column = choice.layer.empty() ? "`sql`" : "`layer`"});
    }
    return {.table = std::filesystem::path(name)};
  }
  if (kind->drivers.empty()) return open_workbook(name, *kind, choice);
  if (module().functions == nullptr) {
    throw InputError(fmt::format("{} cannot be read: {}", kind->format, module().problem),
                     {.file = shown_name(name)});
  }
  return module().functions->open_layer(name, choice, use, target);
}

data::Raster open_raster(const std::string& file, const std::optional<CoordinateSystem>& target) {
  if (module().functions == nullptr) {
    throw InputError("a terrain cannot be read: " + module().problem, {.file = file});
  }
  return module().functions->open_raster(file, target);
}

void require_layer_output(const std::filesystem::path& file) {
  if (is_written_as_workbook(file) || module().functions != nullptr) return;
  throw UsageError(
      fmt::format(
          "files ending in .{} cannot be written: {}", ending_of(file.string()), module().problem),
      {.file = file.string()});
}

void write_layers(const std::filesystem::path& file,
                  const std::vector<Layer>& layers,
                  const std::optional<CoordinateSystem>& coordinates) {
  if (!is_written_as_layers(file)) {
    throw UsageError("the ending must be .gpkg, .fgb, .xlsx or .ods", {.file = file.string()});
  }
  require_layer_output(file);
  // The target is opened first, so that a folder without write permission is reported at once.
  AtomicFile target(file);
  if (is_written_as_workbook(file)) {
    target.stream() << workbook_of(layers, file);
    return target.commit();
  }
  const TemporaryFolder folder("silvafit-layers");
  const std::filesystem::path draft = folder.path() / ("draft." + ending_of(file.string()));
  module().functions->write_draft(draft, file, layers, coordinates);
  std::ifstream written(draft, std::ios::binary);
  target.stream() << written.rdbuf();
  target.commit();
}

std::string gdal_version() {
  return module().functions == nullptr ? std::string() : module().functions->version();
}

}  // namespace silvafit::source
