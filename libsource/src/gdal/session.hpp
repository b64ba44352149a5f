// SPDX-License-Identifier: MIT
// GDAL in this process: which formats it reads, and its messages, which are not printed.
#pragma once

#include <string>
#include <vector>

namespace silvafit::source {

/// Registers the formats of source_kind.hpp and no others, once. Without access to networks GDAL
/// cannot open anything but files and PostgreSQL databases.
void start_gdal();

/// During its lifetime, messages of GDAL in this thread are stored here instead of being printed.
class KeptMessages {
 public:
  KeptMessages();
  ~KeptMessages();
  KeptMessages(const KeptMessages&) = delete;
  KeptMessages& operator=(const KeptMessages&) = delete;

  /// Errors, without warnings.
  const std::vector<std::string>& errors() const { return errors_; }
  void clear() { errors_.clear(); }

  void add(std::string text) { errors_.push_back(std::move(text)); }

 private:
  std::vector<std::string> errors_{};
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
