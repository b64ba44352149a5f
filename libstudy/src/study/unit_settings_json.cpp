// SPDX-License-Identifier: MIT
#include "study/unit_settings_json.hpp"

#include "silvafit/base/json_values.hpp"

namespace silvafit::study {

UnitSettings read_unit_settings(const data::JsonReader& json) {
  UnitSettings settings;
  if (const auto value = json.find("per")) {
    value->one_of({"plot", "stand"});
    settings.per = value->text();
  }
  if (const auto value = json.find("neighbors")) settings.neighbors = value->count();
  if (const auto list = json.find("alpha")) settings.alpha = list->texts();
  if (const auto value = json.find("dominance")) {
    value->one_of({"dbh", "h", "cw"});
    settings.dominance = value->text();
  }
  if (const auto value = json.find("crowding")) {
    value->one_of({"mean", "facing"});
    settings.crowding = value->text();
  }
  if (const auto value = json.find("competition_radius")) {
    settings.competition_radius_m = value->not_negative();
  }
  if (const auto value = json.find("open_grown"); value && !value->is_null()) {
    settings.open_grown = value->text();
  }
  return settings;
}

nlohmann::ordered_json unit_settings_json(const UnitSettings& settings) {
  return {{"per", settings.per},
          {"neighbors", settings.neighbors},
          {"alpha", settings.alpha},
          {"dominance", settings.dominance},
          {"crowding", settings.crowding},
          {"competition_radius", settings.competition_radius_m},
          {"open_grown", text_or_null(settings.open_grown)}};
}

}  // namespace silvafit::study
