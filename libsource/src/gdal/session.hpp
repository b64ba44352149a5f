// SPDX-License-Identifier: MIT
// GDAL in this process: which formats it reads, whether it may use networks, and its messages,
// which are not printed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace silvafit::source {

/// Registers the formats of source_kind.hpp, those of terrains, and no others, once.
void start_gdal();

/// Whether files and requests may use networks, from now on. Without, GDAL's file systems are those
/// of this computer, and its requests fail: a link to a coordinate reference system in a GeoJSON
/// file, a geocoder in a query.
void set_network(bool is_allowed);
/// Whether something was refused for that reason since set_network.
bool has_refused_network();

/// During its lifetime, messages of GDAL in this thread are stored here instead of being printed.
class KeptMessages {
 public:
  KeptMessages();
  ~KeptMessages();
  KeptMessages(const KeptMessages&) = delete;
  KeptMessages& operator=(const KeptMessages&) = delete;

  /// Errors, without warnings.
  const std::vector<std::string>& errors() const { return errors_; }
  /// Whether there were errors, also in threads of GDAL, whose messages are not stored.
  bool has_errors() const;

  void add(std::string text) { errors_.push_back(std::move(text)); }

 private:
  std::vector<std::string> errors_{};
  std::size_t others_before_;
};

/// A setting of GDAL in this thread during its lifetime.
class Setting {
 public:
  Setting(const char* name, const char* value);
  ~Setting();
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

 private:
  std::string name_;
  std::string before_;
  bool had_value_;
};

}  // namespace silvafit::source
