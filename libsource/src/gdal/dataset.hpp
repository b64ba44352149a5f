// SPDX-License-Identifier: MIT
// An open file or database, and the layer of it that is read.
#pragma once

#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gdal/own_data.hpp"
#include "gdal/session.hpp"
#include "silvafit/source/open_table.hpp"
#include "source_kind.hpp"

struct sqlite3;

namespace silvafit::source {

class Dataset {
 public:
  /// \throws InputError if it cannot be opened; UsageError if the choice is not possible
  Dataset(const std::string& name, const TableChoice& choice);
  ~Dataset();
  Dataset(const Dataset&) = delete;
  Dataset& operator=(const Dataset&) = delete;

  /// The requested layer.
  /// \throws InputError if there is none, or several and none is chosen; it lists them
  OGRLayer& choose(const TableChoice& choice, GeometryUse use);

  const SourceKind& kind() const { return kind_; }
  /// Refuses what was read so far if GDAL found an error in it, or more work than the limits of
  /// docs/hardening.md allow.
  /// \param row  from 1; of a layer
  void require_sound(std::optional<std::size_t> row = std::nullopt) const;
  /// The most values, rows times columns, that a table of the file may have.
  std::size_t most_values() const;
  /// For messages: the file, and the layer if the file can have several.
  const std::string& place() const { return place_; }

 private:
  std::vector<OGRLayer*> visible_layers() const;
  OGRLayer& only_layer(GeometryUse use);
  std::vector<QueriedLayer> queried_layers() const;
  OGRLayer& run_query(const TableChoice& choice);
  void require_own(const TableChoice& choice) const;
  sqlite3* database() const;
  void limit_work();
  static int count_step(void* dataset);
  [[noreturn]] void refuse_unreadable() const;
  [[noreturn]] void fail(const std::string& message) const;

  std::string path_;
  const SourceKind& kind_;
  std::string place_;
  std::string layer_name_{};
  std::uintmax_t bytes_ = 0;  // of the file
  std::uintmax_t steps_ = 0;  // of SQLite, in thousands
  bool is_beyond_limit_ = false;
  KeptMessages messages_{};
  std::list<Setting> settings_{};  // outlive the dataset, which reads sheets when they are used
  GDALDatasetUniquePtr dataset_{};
  OGRLayer* result_ = nullptr;  // of a query
};

/// Whether a layer has, or may have, polygons; for circles, points with a radius.
bool may_have_areas(OGRLayer& layer);

}  // namespace silvafit::source
