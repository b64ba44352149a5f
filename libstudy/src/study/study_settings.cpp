// SPDX-License-Identifier: MIT
#include "study/study_settings.hpp"

#include "silvafit/study/setting_list.hpp"
#include "study/settings_json.hpp"

namespace silvafit::study {

nlohmann::ordered_json settings_json(const StudyConfiguration& settings) {
  SettingsWriter writer;
  each_setting(settings, writer);
  return writer.json();
}

}  // namespace silvafit::study
