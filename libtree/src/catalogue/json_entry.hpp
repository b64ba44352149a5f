// SPDX-License-Identifier: MIT
// Reading entries of the catalogue: JSON objects with errors that name the file and the field.
#pragma once

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {

/// An object of a catalogue file with the position of its fields.
class JsonEntry {
 public:
  /// \throws InputError if the file is not a JSON object of that schema
  static JsonEntry load(const std::filesystem::path& file, const std::string& schema) {
    nlohmann::json value = nlohmann::json::parse(read_file(file), nullptr, false);
    if (!value.is_object()) throw InputError("is not a JSON object", {.file = file.string()});
    JsonEntry entry(std::move(value), file.string(), "");
    if (entry.get<std::string>("schema") != schema) {
      throw InputError("must be \"" + schema + "\"", entry.place_of("schema"));
    }
    return entry;
  }

  bool has(const std::string& field) const { return value_.contains(field); }

  /// \throws InputError if the field is missing or of another type
  template <typename T>
  T get(const std::string& field) const {
    const auto found = value_.find(field);
    if (found == value_.end()) throw InputError("is missing", place_of(field));
    try {
      return found->get<T>();
    } catch (const nlohmann::json::exception&) {
      throw InputError("has the wrong type", place_of(field));
    }
  }

  /// A number in [low, high].
  double number(const std::string& field, double low, double high) const {
    const double value = get<double>(field);
    if (!(value >= low && value <= high)) {
      throw InputError(fmt_range(value, low, high), place_of(field));
    }
    return value;
  }

  /// \throws InputError naming the first unknown field
  void allow_only(std::initializer_list<std::string_view> fields) const {
    for (const auto& item : value_.items()) {
      if (std::find(fields.begin(), fields.end(), item.key()) == fields.end()) {
        throw InputError("unknown field", place_of(item.key()));
      }
    }
  }

  JsonEntry child(const std::string& field) const {
    return JsonEntry(get<nlohmann::json>(field), file_, path_ + field + ".");
  }

  /// The objects of an array.
  std::vector<JsonEntry> children(const std::string& field) const {
    const auto values = get<std::vector<nlohmann::json>>(field);
    std::vector<JsonEntry> entries;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string path = path_ + field + "[" + std::to_string(i) + "]";
      if (!values[i].is_object()) {
        throw InputError("is not a JSON object", {.file = file_, .column = path});
      }
      entries.push_back(JsonEntry(values[i], file_, path + "."));
    }
    return entries;
  }

  Place place_of(const std::string& field) const {
    return {.file = file_, .column = path_ + field};
  }
  const std::string& file() const { return file_; }

 private:
  JsonEntry(nlohmann::json value, std::string file, std::string path)
      : value_(std::move(value)), file_(std::move(file)), path_(std::move(path)) {}

  static std::string fmt_range(double value, double low, double high) {
    return nlohmann::json(value).dump() + " is outside [" + nlohmann::json(low).dump() + ", " +
           nlohmann::json(high).dump() + "]";
  }

  nlohmann::json value_;
  std::string file_;
  std::string path_;
};

}  // namespace silvafit::tree
