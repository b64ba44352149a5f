// SPDX-License-Identifier: MIT
#include "likelihood/likelihood_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "likelihood/integration_method.hpp"
#include "model/held_coefficients.hpp"
#include "model/response_fingerprint.hpp"
#include "result/estimated_terms.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

/// Coefficients of a converged fit that have no standard error are held at a value or a bound.
std::map<std::string, double> held_by(const FittedModel& fit) {
  if (!fit.convergence.converged()) {
    throw UsageError("intervals need a converged fit: " + fit.convergence.verdict());
  }
  if (!(fit.sigma > 0.0)) {
    throw UsageError("perfect fit: the residuals are zero, so there are no intervals");
  }
  std::map<std::string, double> held;
  for (Index j = 0; j < fit.estimate.size(); ++j) {
    if (!std::isnan(fit.covariance(j, j))) continue;
    held[fit.coefficient_names[static_cast<std::size_t>(j)]] = fit.estimate[j];
  }
  return held;
}

VectorXd free_estimate(const FittedModel& fit, const std::map<std::string, double>& held) {
  VectorXd result(fit.estimate.size());
  Index count = 0;
  for (Index j = 0; j < result.size(); ++j) {
    const std::string& name = fit.coefficient_names[static_cast<std::size_t>(j)];
    if (!held.contains(name)) result[count++] = fit.estimate[j];
  }
  return result.head(count);
}

void check_same_data(const FittedModel& fit, const NonlinearModel& model) {
  const bool is_same = fit.observations == model.observations() &&
                       (fit.response_fingerprint.empty() ||
                        fit.response_fingerprint == response_fingerprint(model.response()));
  if (is_same) return;
  throw UsageError(
      fmt::format("the table is not the data of the fit: the fit has {} rows, the table has {} "
                  "usable rows or other responses; select the same rows",
                  fit.observations,
                  model.observations()));
}

/// Whether the likelihood is that of the model linear around the estimates.
bool is_linearized(const FittedModel& fit) {
  return fit.method == Method::kLindstromBates || fit.reml || fit.specification.correlation;
}

CoefficientFrame frame_of(const FittedModel& fit,
                          const NonlinearModel& model,
                          const VectorXd& estimate) {
  return is_linearized(fit) ? shared_frame_at(model, estimate) : frame_at(model, estimate);
}

}  // namespace

SurfaceSetting::SurfaceSetting(const FittedModel& of,
                               const data::Table& table,
                               std::stop_token stop)
    : SurfaceSetting(of, table, held_by(of), std::move(stop)) {}

SurfaceSetting::SurfaceSetting(const FittedModel& of,
                               const data::Table& table,
                               const std::map<std::string, double>& held,
                               std::stop_token stop)
    : fit(of),
      model(held.empty() ? of.specification : with_held(of.specification, held),
            table,
            1,
            std::move(stop)),
      variance(model.specification().variance, VarianceData::of(model)),
      estimate(free_estimate(of, held)),
      frame(frame_of(of, model, estimate)),
      internal(variance.parameters(of.variance)),
      log_sigma(std::log(of.sigma / variance.sigma_factor(internal))) {
  check_same_data(fit, model);
}

VectorXd SurfaceSetting::coordinates(const SurfaceLayout& layout, double at_log_sigma) const {
  return layout.coordinates(estimate, covariances_of(fit), internal, at_log_sigma);
}

std::unique_ptr<LikelihoodSurface> make_surface(const SurfaceSetting& setting) {
  if (integration_of(setting.fit.method)) return make_marginal_surface(setting);
  return is_linearized(setting.fit) ? make_linearized_surface(setting)
                                    : make_least_squares_surface(setting);
}

std::string likelihood_in_words(const FittedModel& fit) {
  if (integration_of(fit.method)) {
    return fmt::format("marginal likelihood by {}", word_of(fit.method));
  }
  if (is_linearized(fit)) {
    return fmt::format("{}likelihood of the model linear around the estimates",
                       fit.reml ? "restricted " : "");
  }
  if (fit.method == Method::kOrdinary) return "sum of squares of the nonlinear model";
  return "likelihood of the nonlinear model, with weights from the fitted values of the estimates";
}

}  // namespace silvafit::fit
