// SPDX-License-Identifier: MIT
// Reading JSON files of users and programs. Every error names the file and the key.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/expression.hpp"

namespace silvafit::data {

/// A value in a JSON document, with its path from the root, such as `species[2].dbh.sd`. All
/// members throw InputError with file and path if the document does not have the requested form.
///
/// Files of users are read strictly: texts must not be empty, and numbers must not be missing.
/// Files of programs may lack values, which any_text() and number_or_missing() accept.
class JsonReader {
 public:
  static JsonReader open(const std::filesystem::path& path);
  /// \param comments  whether comments in `//` and `/* */` are allowed
  static JsonReader parse(std::string_view text, std::string file, bool comments = false);

  /// Rejects all other keys, most of which are misspelled.
  void allow_only(const std::vector<std::string_view>& keys) const;
  bool has(std::string_view key) const;
  JsonReader at(std::string_view key) const;
  std::optional<JsonReader> find(std::string_view key) const;

  std::vector<JsonReader> items() const;
  /// In the order of the document.
  std::vector<std::pair<std::string, JsonReader>> members() const;
  /// Sorted by their keys.
  std::vector<std::pair<std::string, JsonReader>> members_by_name() const;

  /// A text that is not empty.
  std::string text() const;
  std::string any_text() const;
  std::vector<std::string> texts() const;
  /// A text or a number, as text.
  std::string label() const;
  /// The index of the text in `names`.
  std::size_t one_of(const std::vector<std::string_view>& names) const;
  /// The value of an enumeration's word.
  template <Worded E>
  E word() const {
    const auto words = words_of(E{});
    return static_cast<E>(one_of({words.begin(), words.end()}));
  }
  bool boolean() const;

  double number() const;
  /// NaN where null.
  double number_or_missing() const;
  double number_between(double low, double high) const;
  /// A number above 0.
  double positive() const;
  /// A number of 0 or more.
  double not_negative() const;
  /// A whole number above 0.
  std::size_t count() const;
  /// A whole number of 0 or more.
  int count_or_zero() const;
  std::vector<double> numbers() const;
  std::map<std::string, double> numbers_by_name() const;
  /// Numbers, NaN where null.
  /// \param size  required number of elements
  Eigen::VectorXd vector(Eigen::Index size) const;
  /// Numbers row by row, NaN where null.
  /// \param size  required number of rows, and of columns
  Eigen::MatrixXd square_matrix(Eigen::Index size) const;

  Expression expression() const;
  std::map<std::string, Expression> expressions_by_name() const;

  bool is_object() const;
  bool is_list() const;
  bool is_null() const;
  const std::string& file() const { return file_; }
  /// The path from the root to this value.
  const std::string& key() const { return key_; }

  /// Throws InputError with the place of this value.
  [[noreturn]] void fail(const std::string& message) const;

 private:
  using Json = nlohmann::ordered_json;
  JsonReader(std::shared_ptr<const Json> root, const Json* value, std::string file, std::string key)
      : root_(std::move(root)), value_(value), file_(std::move(file)), key_(std::move(key)) {}
  JsonReader child(const Json& value, std::string key) const;
  JsonReader member(const Json& value, std::string_view name) const;
  void expect(bool condition, const char* what) const;

  std::shared_ptr<const Json> root_;
  const Json* value_;
  std::string file_;
  std::string key_;
};

}  // namespace silvafit::data
