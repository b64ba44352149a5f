// SPDX-License-Identifier: MIT
// Keyword arguments of Python as settings.
#pragma once

#include <concepts>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::python {

/// Takes each setting from the keyword of its key.
class SettingKeywords {
 public:
  explicit SettingKeywords(Arguments& arguments) : arguments_(arguments) {}

  template <typename T>
  void operator()(const data::Setting<T>& setting) {
    if constexpr (data::HasWords<T>::value) {
      take_word(setting);
    } else if constexpr (std::is_arithmetic_v<T> && !std::same_as<T, bool>) {
      if (arguments_.take(setting.key.data(), setting.value)) data::require_number(setting);
    } else {
      if (!setting.choices.empty()) return take_word(setting);
      arguments_.take(setting.key.data(), setting.value);
    }
  }
  void operator()(const data::Setting<std::vector<std::string>>& setting) {
    const py::object given = arguments_.take(setting.key.data());
    const auto text = [](const auto& value) { return py::str(value).template cast<std::string>(); };
    const bool has_names = setting.type_name.find('=') != std::string_view::npos;
    if (given.is_none()) return;
    setting.value.clear();
    if (has_names && py::isinstance<py::dict>(given)) {
      for (const auto& [key, value] : given.cast<py::dict>()) {
        const std::string name = text(key);
        setting.value.push_back(name.empty() ? text(value) : name + "=" + text(value));
      }
    } else if (py::isinstance<py::str>(given)) {
      setting.value = {text(given)};
    } else {
      const bool is_list = py::isinstance<py::sequence>(given) || py::hasattr(given, "tolist");
      if (!is_list) data::refuse(setting, text(py::repr(given)) + " is a value of the wrong type");
      for (const py::handle one : given) {
        // Labels may be numbers.
        if (!py::isinstance<py::str>(one) && setting.form != data::SettingForm::kNames) {
          data::refuse(setting, text(py::repr(one)) + " is a value of the wrong type");
        }
        setting.value.push_back(text(one));
      }
    }
  }
  /// Whole numbers, or one.
  void operator()(const data::Setting<std::vector<int>>& setting) {
    const py::object given = arguments_.take(setting.key.data());
    if (given.is_none()) return;
    const bool is_one = py::isinstance<py::int_>(given);
    Arguments one(
        py::dict(py::arg(setting.key.data()) = is_one ? py::object(py::make_tuple(given)) : given));
    one.take(setting.key.data(), setting.value);
  }
  /// Pairs of numbers, or None for an open end.
  void operator()(const data::Setting<std::map<std::string, fit::Bounds>>& setting) {
    std::map<std::string, std::pair<std::optional<double>, std::optional<double>>> bounds;
    arguments_.take(setting.key.data(), bounds);
    for (const auto& [name, ends] : bounds) {
      fit::Bounds& range = setting.value[name];
      range = {.low = ends.first.value_or(range.low), .high = ends.second.value_or(range.high)};
    }
  }

 private:
  template <typename T>
  void take_word(const data::Setting<T>& setting) {
    if constexpr (data::HasWords<T>::value || std::same_as<T, bool> ||
                  std::same_as<T, std::string>) {
      std::string word;
      arguments_.take(setting.key.data(), word);
      data::set_word(setting, word);
    }
  }

  Arguments& arguments_;
};

/// The settings of a list, from the keywords of their keys.
template <typename Settings>
Settings settings_of(Arguments& arguments, Settings settings = {}) {
  each_setting(settings, SettingKeywords(arguments));
  return settings;
}

}  // namespace silvafit::python
