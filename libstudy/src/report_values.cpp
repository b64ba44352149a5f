// SPDX-License-Identifier: MIT
#include "report_values.hpp"

#include <cmath>

#include "silvafit/fit/fit_json.hpp"

namespace silvafit::study::report {

using nlohmann::ordered_json;

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json numbers(const std::vector<double>& values) {
  ordered_json array = ordered_json::array();
  for (const double value : values) array.push_back(number(value));
  return array;
}

namespace {

/// Standard errors of a group's random effects, those of the coefficients included.
Eigen::VectorXd prediction_errors(const fit::FittedModel& fit, Eigen::Index group) {
  const Eigen::Index q = fit.random_effects.rows();
  const Eigen::MatrixXd sensitivity = fit.uncertainty.sensitivity(group, q, fit.estimate.size());
  const Eigen::MatrixXd variance =
      fit.uncertainty.covariance(group, q) + sensitivity * fit.covariance * sensitivity.transpose();
  return variance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

ordered_json effect_errors(const fit::FittedModel& fit) {
  ordered_json errors = ordered_json::object();
  for (std::size_t group = 0; group < fit.group_labels.size(); ++group) {
    const Eigen::VectorXd values = prediction_errors(fit, static_cast<Eigen::Index>(group));
    ordered_json& entry = errors[fit.group_labels[group]] = ordered_json::object();
    for (std::size_t k = 0; k < fit.random_names.size(); ++k) {
      entry[fit.random_names[k]] = number(values[static_cast<Eigen::Index>(k)]);
    }
  }
  return errors;
}

}  // namespace

ordered_json fit_object(const fit::FittedModel& fit) {
  ordered_json object = ordered_json::parse(fit::to_json(fit));
  object.erase("seconds");
  if (!fit.has_random_effects() || !fit.uncertainty.is_known()) return object;
  ordered_json& random = object["random"];
  // Matrices of each group would double the page; it shows their diagonals.
  for (const char* key : {"eblup_covariance", "eblup_by_fixed", "eblup_outer_covariance"}) {
    random.erase(key);
  }
  random["eblup_se"] = effect_errors(fit);
  return object;
}

}  // namespace silvafit::study::report
