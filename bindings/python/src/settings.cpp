// SPDX-License-Identifier: MIT
// The settings of the libraries, from which the package makes signatures and docstrings.
#include <pybind11/stl.h>

#include <concepts>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "fits.hpp"
#include "silvafit/study/setting_lists.hpp"

namespace silvafit::python {
namespace {

namespace py = pybind11;

template <typename T>
std::string type_of(const data::SettingHead& setting) {
  if constexpr (std::same_as<T, bool>) return "bool";
  if constexpr (std::integral<T>) return "int";
  if constexpr (std::floating_point<T> || std::same_as<T, std::optional<double>>) return "float";
  if constexpr (std::same_as<T, std::string>) return "str";
  if constexpr (std::same_as<T, std::vector<int>>) return "Sequence[int]";
  if constexpr (std::same_as<T, std::vector<double>>) return "Sequence[float]";
  if constexpr (std::same_as<T, std::map<std::string, double>>) return "Mapping[str, float]";
  if constexpr (std::same_as<T, std::map<std::string, fit::Bounds>>) {
    return "Mapping[str, Tuple[Optional[float], Optional[float]]]";
  }
  if constexpr (std::same_as<T, std::map<std::string, std::vector<std::string>>>) {
    return "Mapping[str, Sequence[str]]";
  }
  if constexpr (std::same_as<T, study::LevelCriteria>) return "Union[str, Mapping[str, str]]";
  return setting.form == data::SettingForm::kMapping ? "Mapping[str, str]" : "Sequence[str]";
}

/// (key, type, default value or None, words that are allowed, meaning) of each setting of a list.
py::list settings(std::string_view name) {
  py::list result;
  const auto describe = [&result]<typename Value>(const data::Setting<Value>& setting) {
    using T = std::remove_const_t<Value>;
    py::object preset = py::none();
    if constexpr (data::HasWords<T>::value) {
      preset = py::cast(data::word_of(setting));
    } else if constexpr (std::same_as<T, bool>) {
      preset = setting.choices.empty() ? py::cast(setting.value) : py::cast(data::word_of(setting));
    } else if constexpr (requires { setting.value.empty(); }) {
      // Lists and mappings are not constants of Python.
      if constexpr (std::same_as<T, std::string>) preset = py::cast(setting.value);
    } else if constexpr (std::is_arithmetic_v<T>) {
      preset = py::cast(setting.value);
    }
    result.append(
        py::make_tuple(setting.key, type_of<T>(setting), preset, setting.choices, setting.help));
  };
  study::each_setting_list([&](std::string_view list, const auto& settings_of_list) {
    if (list == name) each_setting(settings_of_list, describe);
  });
  return result;
}

}  // namespace

void add_settings(py::module_& module) { module.def("settings", &settings); }

}  // namespace silvafit::python
