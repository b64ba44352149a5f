// SPDX-License-Identifier: MIT
// Reading JSON that people write: every complaint names the file and the key.
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/expression.hpp"

namespace silvafit::study {

/// A value somewhere in a JSON document, which knows its way from the root: `species[2].dbh.sd`.
/// All members throw InputError with file and key where the document is not as they ask.
class JsonReader {
 public:
  static JsonReader open(const std::filesystem::path& path);
  /// \param comments  whether `//` and `/* */` may explain the values
  static JsonReader parse(std::string_view text, std::string file, bool comments = false);

  /// Stops at keys that nobody reads, since they are mostly misspelled ones.
  void allow_only(std::initializer_list<std::string_view> keys) const;
  bool has(std::string_view key) const;
  JsonReader at(std::string_view key) const;
  std::optional<JsonReader> find(std::string_view key) const;

  std::vector<JsonReader> items() const;
  std::vector<std::pair<std::string, JsonReader>> members() const;

  std::string text() const;
  double number() const;
  double number_between(double low, double high) const;
  /// A number above 0.
  double positive() const;
  /// A number of 0 or more.
  double not_negative() const;
  std::size_t count() const;
  std::vector<double> numbers() const;
  std::map<std::string, double> numbers_by_name() const;
  std::vector<std::string> texts() const;
  data::Expression expression() const;
  std::map<std::string, data::Expression> expressions_by_name() const;
  /// The index of the text in `names`.
  std::size_t one_of(std::initializer_list<std::string_view> names) const;

  bool is_object() const { return value_->is_object(); }
  bool is_null() const { return value_->is_null(); }
  const std::string& file() const { return file_; }
  /// The way from the root to this value.
  const std::string& key() const { return key_; }

  /// Throws InputError with the place of this value.
  [[noreturn]] void fail(const std::string& message) const;

 private:
  JsonReader(std::shared_ptr<const nlohmann::json> root,
             const nlohmann::json* value,
             std::string file,
             std::string key)
      : root_(std::move(root)), value_(value), file_(std::move(file)), key_(std::move(key)) {}
  JsonReader child(const nlohmann::json& value, std::string key) const;
  void expect(bool condition, const char* what) const;

  std::shared_ptr<const nlohmann::json> root_;
  const nlohmann::json* value_;
  std::string file_;
  std::string key_;
};

}  // namespace silvafit::study
