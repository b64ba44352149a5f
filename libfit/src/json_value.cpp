// SPDX-License-Identifier: MIT
#include "json_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

std::string kind_of(const nlohmann::ordered_json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  return value.dump();
}

}  // namespace

JsonValue JsonValue::parse(std::string_view text, std::string file, std::string key) {
  try {
    auto root = std::make_shared<const Json>(Json::parse(text));
    const Json* value = root.get();
    return {std::move(root), value, std::move(file), std::move(key)};
  } catch (const Json::parse_error& error) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, text.size()));
    const auto line = static_cast<std::size_t>(1 + std::count(text.begin(), end, '\n'));
    throw InputError("this is not JSON; look for a missing comma, quote or bracket",
                     {.file = std::move(file), .line = line, .column = std::move(key)});
  } catch (const Json::out_of_range&) {
    throw InputError("a number in it is too large",
                     {.file = std::move(file), .column = std::move(key)});
  }
}

JsonValue JsonValue::child(const Json& value, std::string key) const {
  return {root_, &value, file_, std::move(key)};
}

void JsonValue::fail(const std::string& message) const {
  throw InputError(message, {.file = file_, .column = key_});
}

void JsonValue::expect(bool condition, const char* what) const {
  if (!condition) fail(fmt::format("must be {}, is {}", what, kind_of(*value_)));
}

JsonValue JsonValue::at(std::string_view key) const {
  expect(value_->is_object(), "an object");
  const auto item = value_->find(key);
  if (item == value_->end()) fail(fmt::format("the key \"{}\" is missing", key));
  return child(*item, key_.empty() ? std::string(key) : fmt::format("{}.{}", key_, key));
}

std::vector<std::pair<std::string, JsonValue>> JsonValue::members() const {
  expect(value_->is_object(), "an object");
  std::vector<std::pair<std::string, JsonValue>> result;
  for (const auto& item : value_->items()) result.emplace_back(item.key(), at(item.key()));
  return result;
}

std::vector<JsonValue> JsonValue::items() const {
  expect(value_->is_array(), "a list");
  std::vector<JsonValue> result;
  for (std::size_t i = 0; i < value_->size(); ++i) {
    result.push_back(child((*value_)[i], fmt::format("{}[{}]", key_, i)));
  }
  return result;
}

std::string JsonValue::text() const {
  expect(value_->is_string(), "a text");
  return value_->get<std::string>();
}

std::vector<std::string> JsonValue::texts() const {
  std::vector<std::string> result;
  for (const JsonValue& item : items()) result.push_back(item.text());
  return result;
}

bool JsonValue::boolean() const {
  expect(value_->is_boolean(), "true or false");
  return value_->get<bool>();
}

double JsonValue::number() const {
  if (value_->is_null()) return std::numeric_limits<double>::quiet_NaN();
  expect(value_->is_number(), "a number or null");
  return value_->get<double>();
}

int JsonValue::count() const {
  const double value = number();
  expect(value >= 0.0 && value <= std::numeric_limits<int>::max() && value == std::floor(value),
         "a whole number of 0 or more");
  return static_cast<int>(value);
}

Eigen::VectorXd JsonValue::vector(Eigen::Index size) const {
  const std::vector<JsonValue> values = items();
  if (static_cast<Eigen::Index>(values.size()) != size) {
    fail(fmt::format("must have {} numbers, has {}", size, values.size()));
  }
  Eigen::VectorXd result(size);
  for (Eigen::Index i = 0; i < size; ++i) result[i] = values[static_cast<std::size_t>(i)].number();
  return result;
}

Eigen::MatrixXd JsonValue::square_matrix(Eigen::Index size) const {
  const std::vector<JsonValue> rows = items();
  if (static_cast<Eigen::Index>(rows.size()) != size) {
    fail(fmt::format("must have {} rows, has {}", size, rows.size()));
  }
  Eigen::MatrixXd result(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    result.row(i) = rows[static_cast<std::size_t>(i)].vector(size).transpose();
  }
  return result;
}

}  // namespace silvafit::fit
