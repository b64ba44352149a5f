// SPDX-License-Identifier: MIT
#include "json/json_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

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

}  // namespace

Json parse_document(std::string_view text, const std::string& file, bool comments) {
  DocumentBuilder builder(text, file);
  Json::sax_parse(text, &builder, Json::input_format_t::json, true, comments);
  return builder.take();
}

}  // namespace silvafit::data
