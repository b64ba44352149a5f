// SPDX-License-Identifier: MIT
#include "fit_handle.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "conversion.hpp"
#include "entry_points.hpp"
#include "handle.hpp"
#include "silvafit/base/error.hpp"
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
void shorten_random_effects(nlohmann::ordered_json& fit) {
  fit.erase("random_cells");
  for (auto& term : fit["random"]) {
    for (const char* const key : {"eblup", "eblup_se", "eblup_covariance"}) {
      if (term.contains(key)) term[key] = rows_of_groups(term[key]);
    }
    term.erase("eblup_by_fixed");
  }
}

}  // namespace

cpp11::sexp list_of_fit(fit::FittedModel fit) {
  nlohmann::ordered_json json = fit::json_of(fit);
  const std::string text = json_text(json);
  shorten_random_effects(json);
  json.erase("random_cells");
  NamedList list;
  list.add("handle", handle_of(std::move(fit), text));
  list.add("fit", value_of(json));
  return list.list();
}

const fit::FittedModel& fit_of(SEXP handle) {
  return object_of<fit::FittedModel>(
      handle, [](const std::string& json) { return fit::from_json(json, "the fit"); });
}

SEXP text_of_fit(SEXP handle) { return R_ExternalPtrProtected(handle); }

SEXP read_fit(SEXP json, SEXP file) {
  return list_of_fit(fit::from_json(text_of(json), text_of(file)));
}

SEXP with_estimates(SEXP handle, SEXP estimates) {
  fit::FittedModel fit = fit_of(handle);
  const std::vector<double> values = numbers_of(estimates);
  if (static_cast<Eigen::Index>(values.size()) != fit.estimate.size()) {
    throw UsageError("the fit has " + std::to_string(fit.estimate.size()) + " fixed effects");
  }
  fit.estimate = Eigen::Map<const Eigen::VectorXd>(values.data(), fit.estimate.size());
  const std::string json = json_text(fit::json_of(fit));
  return handle_of(std::move(fit), json);
}

}  // namespace silvafit::r
