// SPDX-License-Identifier: MIT
#include "json_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::study {
namespace {

std::string kind_of(const nlohmann::json& value) {
  if (value.is_string()) return fmt::format("\"{}\"", value.get<std::string>());
  if (value.is_object()) return "an object";
  if (value.is_array()) return "a list";
  return value.dump();
}

std::string joined(std::initializer_list<std::string_view> names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

JsonReader JsonReader::open(const std::filesystem::path& path) {
  return parse(read_file(path), path.string());
}

JsonReader JsonReader::parse(std::string_view text, std::string file, bool comments) {
  try {
    auto root = std::make_shared<const nlohmann::json>(
        nlohmann::json::parse(text, nullptr, true, comments));
    const nlohmann::json* value = root.get();
    return {std::move(root), value, std::move(file), ""};
  } catch (const nlohmann::json::parse_error& error) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, text.size()));
    const auto line = static_cast<std::size_t>(1 + std::count(text.begin(), end, '\n'));
    throw InputError("this is not JSON; look for a missing comma, quote or bracket",
                     {.file = std::move(file), .line = line});
  } catch (const nlohmann::json::out_of_range&) {
    throw InputError("a number in it is too large", {.file = std::move(file)});
  }
}

JsonReader JsonReader::child(const nlohmann::json& value, std::string key) const {
  return {root_, &value, file_, std::move(key)};
}

void JsonReader::fail(const std::string& message) const {
  throw InputError(message, {.file = file_, .column = key_});
}

void JsonReader::expect(bool condition, const char* what) const {
  if (!condition) fail(fmt::format("must be {}, is {}", what, kind_of(*value_)));
}

void JsonReader::allow_only(std::initializer_list<std::string_view> keys) const {
  expect(value_->is_object(), "an object");
  for (const auto& item : value_->items()) {
    if (std::find(keys.begin(), keys.end(), item.key()) == keys.end()) {
      fail(fmt::format("the key \"{}\" is not known here; known are {}", item.key(), joined(keys)));
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
  return child(*item, key_.empty() ? std::string(key) : fmt::format("{}.{}", key_, key));
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
  for (const auto& item : value_->items()) result.emplace_back(item.key(), at(item.key()));
  return result;
}

std::string JsonReader::text() const {
  expect(value_->is_string() && !value_->get_ref<const std::string&>().empty(), "a text");
  return value_->get<std::string>();
}

double JsonReader::number() const {
  expect(value_->is_number() && std::isfinite(value_->get<double>()), "a number");
  return value_->get<double>();
}

double JsonReader::number_between(double low, double high) const {
  const double result = number();
  if (!(result >= low && result <= high)) {
    fail(fmt::format("must be between {} and {}, is {}", low, high, result));
  }
  return result;
}

double JsonReader::positive() const {
  const double result = number();
  if (!(result > 0.0)) fail(fmt::format("must be above 0, is {}", result));
  return result;
}

double JsonReader::not_negative() const {
  const double result = number();
  if (!(result >= 0.0)) fail(fmt::format("must not be negative, is {}", result));
  return result;
}

std::size_t JsonReader::count() const {
  expect(value_->is_number_unsigned() && value_->get<std::size_t>() > 0, "a whole number above 0");
  return value_->get<std::size_t>();
}

std::vector<double> JsonReader::numbers() const {
  std::vector<double> result;
  for (const JsonReader& item : items()) result.push_back(item.number());
  return result;
}

std::map<std::string, double> JsonReader::numbers_by_name() const {
  std::map<std::string, double> result;
  for (const auto& [name, value] : members()) result.emplace(name, value.number());
  return result;
}

std::vector<std::string> JsonReader::texts() const {
  std::vector<std::string> result;
  for (const JsonReader& item : items()) result.push_back(item.text());
  return result;
}

data::Expression JsonReader::expression() const {
  const std::string source = text();
  try {
    return data::Expression::parse(source);
  } catch (const FormulaError& error) {
    fail(error.what());
  }
}

std::map<std::string, data::Expression> JsonReader::expressions_by_name() const {
  std::map<std::string, data::Expression> result;
  for (const auto& [name, value] : members()) result.emplace(name, value.expression());
  return result;
}

std::size_t JsonReader::one_of(std::initializer_list<std::string_view> names) const {
  const std::string value = text();
  const auto* const found = std::find(names.begin(), names.end(), value);
  if (found == names.end()) {
    fail(fmt::format("must be one of {}, is \"{}\"", joined(names), value));
  }
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace silvafit::study
