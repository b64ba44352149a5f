// SPDX-License-Identifier: MIT
// Reading JSON that programs wrote: members in their order, null as NaN, complaints with file and
// key.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace silvafit::fit {

/// A value somewhere in a JSON document, which knows its way from the root. All members throw
/// InputError with file and key where the document is not as they ask.
class JsonValue {
 public:
  /// \param key  place of the text in its file, the root of all keys in messages
  static JsonValue parse(std::string_view text, std::string file, std::string key);

  JsonValue at(std::string_view key) const;
  bool has(std::string_view key) const { return value_->is_object() && value_->contains(key); }
  bool is_null() const { return value_->is_null(); }

  std::vector<std::pair<std::string, JsonValue>> members() const;
  std::vector<JsonValue> items() const;

  std::string text() const;
  std::vector<std::string> texts() const;
  bool boolean() const;
  /// NaN where null.
  double number() const;
  /// A whole number of 0 or more.
  int count() const;
  /// \param size  how many numbers there must be
  Eigen::VectorXd vector(Eigen::Index size) const;
  /// \param size  rows and columns
  Eigen::MatrixXd square_matrix(Eigen::Index size) const;

  /// Throws InputError with the place of this value.
  [[noreturn]] void fail(const std::string& message) const;

 private:
  using Json = nlohmann::ordered_json;
  JsonValue(std::shared_ptr<const Json> root, const Json* value, std::string file, std::string key)
      : root_(std::move(root)), value_(value), file_(std::move(file)), key_(std::move(key)) {}
  JsonValue child(const Json& value, std::string key) const;
  void expect(bool condition, const char* what) const;

  std::shared_ptr<const Json> root_;
  const Json* value_;
  std::string file_;
  std::string key_;
};

}  // namespace silvafit::fit
