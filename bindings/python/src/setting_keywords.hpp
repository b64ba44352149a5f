// SPDX-License-Identifier: MIT
// Keyword arguments of Python as settings.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/tree/builder.hpp"

namespace silvafit::python {

/// Takes each setting from the keyword of its key.
class SettingKeywords {
 public:
  explicit SettingKeywords(Arguments& arguments) : arguments_(arguments) {}

  template <typename T>
  void operator()(const data::Setting<T>& setting) {
    arguments_.take(setting.key.data(), setting.value);
  }
  void operator()(const data::Setting<std::vector<std::string>>& setting) {
    if (setting.form != data::SettingForm::kMapping) {
      return arguments_.take(setting.key.data(), setting.value);
    }
    std::map<std::string, std::string> sources;
    arguments_.take(setting.key.data(), sources);
    for (const auto& [name, source] : sources) setting.value.push_back(name + "=" + source);
  }
  void operator()(const data::Setting<tree::BuilderKind>& setting) {
    std::string name;
    arguments_.take(setting.key.data(), name);
    if (!name.empty()) setting.value = tree::builder_from_text(name);
  }

 private:
  Arguments& arguments_;
};

}  // namespace silvafit::python
