// SPDX-License-Identifier: MIT
#include "fit_model/limit_of_curve.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "least_squares/least_squares_verdict.hpp"
#include "mixed_effects/expected_information.hpp"
#include "model/coefficient_frame.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Coefficients that the population's curve hardly determines, least determined first.
std::vector<Index> candidates(const NonlinearModel& model, const FitResult& result) {
  const FittedModel& fit = result.fit;
  const VectorXd errors =
      expected_covariance(
          model, fit, fit.estimate, result.residual_sd, frame_at(model, fit.estimate).beta)
          .diagonal()
          .cwiseSqrt();
  std::vector<Index> found = undetermined(model, fit.estimate, errors, result.residual_sd);
  std::ranges::stable_sort(found, std::ranges::greater(), [&](Index j) {
    return errors[j] / std::abs(fit.estimate[j]);
  });
  return found;
}

bool is_random(const ModelSpecification& specification, const std::string& name) {
  return std::ranges::any_of(specification.random, [&](const RandomEffects& term) {
    return std::ranges::find(term.coefficients, name) != term.coefficients.end();
  });
}

/// Whether the likelihood with the coefficient held far towards one side is as high as that of the
/// fit. Where the formula has no values so far away, nearer values are tried.
bool is_flat_towards(const FittedModel& fit,
                     Index coefficient,
                     double sign,
                     const HeldFit& held_fit) {
  // Searches end within this difference of a likelihood that increases ever more slowly.
  constexpr double kResolved = 1e-3;
  for (const double decades : {3.0, 2.0, 1.0, 0.3}) {
    const double value = fit.estimate[coefficient] * std::pow(10.0, sign * decades);
    const HeldValues held{{fit.coefficient_names[static_cast<std::size_t>(coefficient)], value}};
    for (const FittedModel* const nearby : {&fit, static_cast<const FittedModel*>(nullptr)}) {
      const FittedModel far = held_fit(held, nearby).fit;
      if (far.log_likelihood >= fit.log_likelihood - kResolved) return true;
      if (far.convergence.converged() && nearby == nullptr) return false;
    }
  }
  return false;
}

}  // namespace

void mark_limit(const NonlinearModel& model, const HeldFit& held_fit, FitResult& result) {
  FittedModel& fit = result.fit;
  const bool is_known = result.residual_sd.size() > 0 && result.residual_sd.allFinite();
  if (!fit.convergence.converged() || !is_known) return;
  const std::vector<Index> loose = candidates(model, result);
  const auto held = std::ranges::find_if(loose, [&](Index j) {
    return !is_random(fit.specification, fit.coefficient_names[static_cast<std::size_t>(j)]);
  });
  if (held == loose.end()) return;
  if (!is_flat_towards(fit, *held, 1.0, held_fit) && !is_flat_towards(fit, *held, -1.0, held_fit)) {
    return;
  }
  fit.convergence.status = ConvergenceStatus::kNoMaximum;
  std::erase_if(fit.convergence.evidence, [](const Evidence& item) {
    return item.kind == Evidence::Kind::kHardlyIdentifiable;
  });
  fit.convergence.add(Evidence::Kind::kUnbounded, names_of(model, loose));
  // The Hessian is not one at a maximum.
  fit.covariance.setConstant(kNaN);
  fit.convergence.verdict =
      "Not converged: the log-likelihood has no maximum; it is as high as here, or higher, while " +
      unbounded_text(model, loose);
}

}  // namespace silvafit::fit
