// SPDX-License-Identifier: MIT
#include "fit_handle.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "conversion.hpp"
#include "handle.hpp"
#include "silvafit/base/json_text.hpp"

namespace silvafit::r {
namespace {

/// The numbers of nested arrays and objects, one after the other.
void add_numbers(const nlohmann::ordered_json& json, nlohmann::ordered_json& values) {
  if (!json.is_structured()) {
    values.push_back(json);
    return;
  }
  for (const auto& part : json) add_numbers(part, values);
}

/// The effects of all groups as a matrix with a row for each group, in the place of an object of
/// objects: many groups would be as many lists of R.
nlohmann::ordered_json rows_of_groups(const nlohmann::ordered_json& groups) {
  nlohmann::ordered_json labels = nlohmann::ordered_json::array();
  nlohmann::ordered_json values = nlohmann::ordered_json::array();
  for (const auto& [label, effects] : groups.items()) {
    labels.push_back(label);
    add_numbers(effects, values);
  }
  return {{"groups", std::move(labels)}, {"values", std::move(values)}};
}

/// The only function that reads random effects: what R shows of them. Uncertainties, which only
/// predictions need, stay in the text of the fit.
void shorten_random_effects(nlohmann::ordered_json& random) {
  if (random.is_array()) {
    for (auto& term : random) shorten_random_effects(term);
  }
  if (!random.is_object()) return;
  for (const char* const key : {"eblup", "eblup_se", "eblup_covariance"}) {
    if (random.contains(key) && random[key].is_object()) random[key] = rows_of_groups(random[key]);
  }
  for (const char* const key :
       {"eblup_by_fixed", "eblup_cross_covariance", "eblup_outer_covariance"}) {
    random.erase(key);
  }
  // Files of schema silvafit-fit/1 have the coarser grouping here.
  if (random.contains("outer")) shorten_random_effects(random["outer"]);
}

}  // namespace

cpp11::sexp list_of_fit(fit::FittedModel fit) {
  nlohmann::ordered_json json = fit::json_of(fit);
  const std::string text = json_text(json);
  shorten_random_effects(json["random"]);
  NamedList list;
  list.add("handle", handle_of(std::move(fit), text));
  list.add("fit", value_of(json));
  return list.list();
}

const fit::FittedModel& fit_of(SEXP handle) {
  return object_of<fit::FittedModel>(
      handle, [](const std::string& json) { return fit::from_json(json, "the fit"); });
}

SEXP json_of(SEXP handle) { return R_ExternalPtrProtected(handle); }

}  // namespace silvafit::r
