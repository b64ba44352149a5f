// SPDX-License-Identifier: MIT
// What a build without GDAL does: CSV files are read as ever, for others it says what to install.
#include "silvafit/source/open_table.hpp"

#include <fmt/format.h>

#include "silvafit/base/error.hpp"
#include "silvafit/source/write_layers.hpp"
#include "source_kind.hpp"

namespace silvafit::source {
namespace {

constexpr const char* kRemedy =
    "this silvafit was built without GDAL; install libgdal-dev and build it again, or use CSV";

}  // namespace

OpenedTable open_table(const std::string& name,
                       const TableChoice& choice,
                       GeometryUse /*use*/,
                       const std::optional<CoordinateSystem>& /*target*/) {
  const SourceKind* const kind = kind_of_source(name);
  if (kind != nullptr) {
    throw InputError(fmt::format("{} cannot be read: {}", kind->format, kRemedy),
                     {.file = shown_name(name)});
  }
  if (!choice.layer.empty() || !choice.sql.empty()) {
    throw UsageError("a CSV file has no layers",
                     {.column = choice.layer.empty() ? "--sql" : "--layer"});
  }
  return {.table = std::filesystem::path(name)};
}

void require_layer_output(const std::filesystem::path& file) {
  throw UsageError(
      fmt::format("files ending in .{} cannot be written: {}", ending_of(file.string()), kRemedy),
      {.file = file.string()});
}

void write_layers(const std::filesystem::path& file,
                  const std::vector<Layer>& /*layers*/,
                  const std::optional<CoordinateSystem>& /*coordinates*/) {
  require_layer_output(file);
}

std::string gdal_version() { return {}; }

}  // namespace silvafit::source
