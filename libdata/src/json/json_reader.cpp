// SPDX-License-Identifier: MIT
#include "silvafit/data/json_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::data {
namespace {

using Json = nlohmann::ordered_json;

/// Builds the value from the events of nlohmann-json's parser.
class DocumentBuilder final : public nlohmann::json_sax<Json> {
 public:
  DocumentBuilder(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  Json take() { return std::move(root_); }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t& /*text*/) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t& value) override { return add(std::move(value)); }
  bool start_array(std::size_t /*size*/) override { return open(Json::array()); }
  bool start_object(std::size_t /*size*/) override { return open(Json::object()); }
  bool key(string_t& name) override {
    key_ = std::move(name);
    return true;
  }
  bool end_array() override {
    open_.pop_back();
    return true;
  }
  bool end_object() override {
    refuse_repeated(open_.back()->get_ref<const Json::object_t&>());
    open_.pop_back();
    return true;
  }

  [[noreturn]] bool parse_error(std::size_t position,
                                const std::string& /*token*/,
                                const nlohmann::detail::exception& error) override {
    if (dynamic_cast<const Json::out_of_range*>(&error) != nullptr) {
      throw InputError("a number is too large", {.file = file_});
    }
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(position, text_.size()));
    const auto line = static_cast<std::size_t>(1 + std::count(text_.begin(), end, '\n'));
    throw InputError("not valid JSON; look for a missing comma, quote or bracket",
                     {.file = file_, .line = line});
  }

 private:
  /// Adds a value at the current position of the document; returns its address.
  Json* place(Json value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    Json& parent = *open_.back();
    if (parent.is_array()) {
      parent.push_back(std::move(value));
      return &parent.back();
    }
    auto& members = parent.get_ref<Json::object_t&>();
    members.push_back({std::move(key_), std::move(value)});
    return &members.back().second;
  }

  bool add(Json value) {
    place(std::move(value));
    return true;
  }

  /// Pointers to open lists and objects stay valid, because only the innermost one grows.
  bool open(Json value) {
    open_.push_back(place(std::move(value)));
    return true;
  }

  void refuse_repeated(const Json::object_t& members) const {
    std::vector<std::string_view> names;
    names.reserve(members.size());
    for (const auto& [name, value] : members) names.emplace_back(name);
    std::ranges::sort(names);
    const auto repeated = std::ranges::adjacent_find(names);
    if (repeated == names.end()) return;
    throw InputError(fmt::format("the key \"{}\" occurs twice in an object", *repeated),
                     {.file = file_});
  }

  std::string_view text_;
  const std::string& file_;
  Json root_{};
  std::string key_{};
  std::vector<Json*> open_{};  ///< lists and objects that contain the current position
};

/// The value of a text, the members of objects in their order.
///
/// nlohmann-json's own reader compares each key with those before it, which takes seconds for an
/// object with a member for each of ten thousand plots; this one compares keys when the object is
/// complete.
/// \param comments  whether `//` and `/* */` may explain the values
/// \throws InputError with file and line if this is no JSON, a number in it is too large, or an
///   object has a key twice
Json parse_document(std::string_view text, const std::string& file, bool comments) {
  DocumentBuilder builder(text, file);
  Json::sax_parse(text, &builder, Json::input_format_t::json, true, comments);
  return builder.take();
}

std::string kind_of(const nlohmann::ordered_json& value) {
  if (value.is_string()) return fmt::format("\"{}\"", value.get_ref<const std::string&>());
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  return value.dump();
}

std::string joined(const std::vector<std::string_view>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

JsonReader JsonReader::open(const std::filesystem::path& path) {
  return parse(read_file(path), path.string());
}

JsonReader JsonReader::parse(std::string_view text, std::string file, bool comments) {
  auto root = std::make_shared<const Json>(parse_document(text, file, comments));
  const Json* value = root.get();
  return {std::move(root), value, std::move(file), ""};
}

JsonReader JsonReader::child(const Json& value, std::string key) const {
  return {root_, &value, file_, std::move(key)};
}

JsonReader JsonReader::member(const Json& value, std::string_view name) const {
  return child(value, key_.empty() ? std::string(name) : fmt::format("{}.{}", key_, name));
}

void JsonReader::fail(const std::string& message) const {
  throw InputError(message, {.file = file_, .column = key_});
}

void JsonReader::expect(bool condition, const char* what) const {
  if (!condition) fail(fmt::format("must be {}, not {}", what, kind_of(*value_)));
}

bool JsonReader::is_object() const { return value_->is_object(); }

bool JsonReader::is_list() const { return value_->is_array(); }

bool JsonReader::is_null() const { return value_->is_null(); }

void JsonReader::allow_only(const std::vector<std::string_view>& keys) const {
  for (const auto& [name, value] : members_by_name()) {
    if (std::ranges::find(keys, name) == keys.end()) {
      fail(fmt::format("unknown key \"{}\"; available: {}", name, joined(keys)));
    }
  }
}

bool JsonReader::has(std::string_view key) const {
  return value_->is_object() && value_->contains(key);
}

JsonReader JsonReader::at(std::string_view key) const {
  std::optional<JsonReader> found = find(key);
  if (!found) fail(fmt::format("the key \"{}\" is missing", key));
  return *std::move(found);
}

std::optional<JsonReader> JsonReader::find(std::string_view key) const {
  expect(value_->is_object(), "an object");
  const auto item = value_->find(key);
  if (item == value_->end()) return std::nullopt;
  return member(*item, key);
}

std::vector<JsonReader> JsonReader::items() const {
  expect(value_->is_array(), "a list");
  std::vector<JsonReader> result;
  result.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i) {
    result.push_back(child((*value_)[i], fmt::format("{}[{}]", key_, i)));
  }
  return result;
}

std::vector<std::pair<std::string, JsonReader>> JsonReader::members() const {
  expect(value_->is_object(), "an object");
  std::vector<std::pair<std::string, JsonReader>> result;
  result.reserve(value_->size());
  for (const auto& item : value_->items()) {
    result.emplace_back(item.key(), member(item.value(), item.key()));
  }
  return result;
}

std::vector<std::pair<std::string, JsonReader>> JsonReader::members_by_name() const {
  std::vector<std::pair<std::string, JsonReader>> result = members();
  std::ranges::sort(result, {}, &std::pair<std::string, JsonReader>::first);
  return result;
}

std::string JsonReader::text() const {
  expect(value_->is_string() && !value_->get_ref<const std::string&>().empty(), "a text");
  return value_->get<std::string>();
}

std::string JsonReader::any_text() const {
  expect(value_->is_string(), "a text");
  return value_->get<std::string>();
}

std::vector<std::string> JsonReader::texts() const {
  std::vector<std::string> result;
  for (const JsonReader& item : items()) result.push_back(item.text());
  return result;
}

std::string JsonReader::label() const {
  return value_->is_number() ? fmt::format("{}", number()) : any_text();
}

std::size_t JsonReader::one_of(const std::vector<std::string_view>& names) const {
  const std::string value = text();
  const auto found = std::ranges::find(names, value);
  if (found == names.end()) {
    fail(fmt::format("must be one of {}, not \"{}\"", joined(names), value));
  }
  return static_cast<std::size_t>(found - names.begin());
}

bool JsonReader::boolean() const {
  expect(value_->is_boolean(), "true or false");
  return value_->get<bool>();
}

double JsonReader::number() const {
  expect(value_->is_number() && std::isfinite(value_->get<double>()), "a number");
  return value_->get<double>();
}

double JsonReader::number_or_missing() const {
  if (value_->is_null()) return std::numeric_limits<double>::quiet_NaN();
  expect(value_->is_number(), "a number or null");
  return value_->get<double>();
}

double JsonReader::number_between(double low, double high) const {
  const double result = number();
  if (!(result >= low && result <= high)) {
    fail(fmt::format("must be between {} and {}, not {}", low, high, result));
  }
  return result;
}

double JsonReader::positive() const {
  const double result = number();
  if (!(result > 0.0)) fail(fmt::format("must be above 0, not {}", result));
  return result;
}

double JsonReader::not_negative() const {
  const double result = number();
  if (!(result >= 0.0)) fail(fmt::format("must be 0 or more, not {}", result));
  return result;
}

std::size_t JsonReader::count() const {
  expect(value_->is_number_unsigned() && value_->get<std::size_t>() > 0, "a whole number above 0");
  return value_->get<std::size_t>();
}

int JsonReader::count_or_zero() const {
  const double value = number_or_missing();
  expect(value >= 0.0 && value <= std::numeric_limits<int>::max() && value == std::floor(value),
         "a whole number of 0 or more");
  return static_cast<int>(value);
}

std::vector<double> JsonReader::numbers() const {
  std::vector<double> result;
  for (const JsonReader& item : items()) result.push_back(item.number());
  return result;
}

std::map<std::string, double> JsonReader::numbers_by_name() const {
  std::map<std::string, double> result;
  for (const auto& [name, value] : members_by_name()) result.emplace(name, value.number());
  return result;
}

Eigen::VectorXd JsonReader::vector(Eigen::Index size) const {
  const std::vector<JsonReader> values = items();
  if (static_cast<Eigen::Index>(values.size()) != size) {
    fail(fmt::format("must have {} numbers, not {}", size, values.size()));
  }
  Eigen::VectorXd result(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    result[i] = values[static_cast<std::size_t>(i)].number_or_missing();
  }
  return result;
}

Eigen::MatrixXd JsonReader::square_matrix(Eigen::Index size) const {
  const std::vector<JsonReader> rows = items();
  if (static_cast<Eigen::Index>(rows.size()) != size) {
    fail(fmt::format("must have {} rows, not {}", size, rows.size()));
  }
  Eigen::MatrixXd result(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    result.row(i) = rows[static_cast<std::size_t>(i)].vector(size).transpose();
  }
  return result;
}

Expression JsonReader::expression() const {
  const std::string source = text();
  try {
    return Expression::parse(source);
  } catch (const FormulaError& error) {
    fail(error.what());
  }
}

std::map<std::string, Expression> JsonReader::expressions_by_name() const {
  std::map<std::string, Expression> result;
  for (const auto& [name, value] : members_by_name()) result.emplace(name, value.expression());
  return result;
}

}  // namespace silvafit::data
