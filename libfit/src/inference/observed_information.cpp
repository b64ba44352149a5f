// SPDX-License-Identifier: MIT
#include "silvafit/fit/observed_information.hpp"

#include "inference/information.hpp"
#include "model/symmetric_eigen.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::string scale_text(const NaturalParameter& parameter) {
  switch (parameter.form) {
    case NaturalParameter::Form::kCoefficient:
    case NaturalParameter::Form::kCoordinate:
      return "identity";
    case NaturalParameter::Form::kCorrelation:
      return "fisher";
    default:
      return "log";
  }
}

double smallest_curvature(const MatrixXd& hessian) {
  const VectorXd unit = hessian.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return symmetric_eigen(unit.asDiagonal() * hessian * unit.asDiagonal()).values[0];
}

}  // namespace

ObservedInformation observed_information(const FittedModel& fit, const data::Table& table) {
  const SurfaceSetting setting(fit, table);
  const auto surface = make_surface(setting);
  const SurfaceLayout& layout = surface->layout();
  const std::vector<NaturalParameter> parameters = natural_parameters(setting, layout);
  const ProfileStart start = start_of(setting, *surface);
  ObservedInformation result{.likelihood = likelihood_in_words(fit)};
  result.estimate.resize(static_cast<Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    result.names.push_back(parameters[k].name);
    result.scales.push_back(scale_text(parameters[k]));
    result.estimate[static_cast<Index>(k)] =
        parameters[k].value(layout, setting.variance, surface->optimum());
  }
  result.covariance = symmetric_covariance(setting, *surface, parameters, start);
  if (fit.method == Method::kOrdinary) {
    // The likelihood is highest with n in place of the n - p of the estimate of sigma^2.
    const auto n = static_cast<double>(setting.model.observations());
    result.covariance *= n / (n - static_cast<double>(layout.beta_count()));
    result.estimate[result.estimate.size() - 1] = fit.sigma;
  }
  const Index p = layout.beta_count();
  result.fixed_covariance = result.covariance.topLeftCorner(p, p);
  result.smallest_curvature = smallest_curvature(start.hessian);
  return result;
}

}  // namespace silvafit::fit
