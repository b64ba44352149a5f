// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <utility>

#include "lindstrom_bates/lindstrom_bates.hpp"
#include "lindstrom_bates/lindstrom_bates_search.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "result/estimated_terms.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MixedEffectsFit failed(const NonlinearModel& model, const VectorXd& start, Convergence reason) {
  MixedEffectsFit fit;
  fit.estimate = start;
  fit.covariance = MatrixXd::Constant(start.size(), start.size(), kNaN);
  fit.random = missing_terms(model);
  fit.sigma = kNaN;
  fit.log_likelihood = kNaN;
  fit.observations = model.observations();
  fit.fitted_population = VectorXd::Constant(model.observations(), kNaN);
  fit.fitted_conditional = fit.fitted_population;
  fit.residual_sd = fit.fitted_population;
  fit.variance = VarianceEstimate::missing(model.specification().variance);
  fit.convergence = std::move(reason);
  return fit;
}

}  // namespace

MixedEffectsFit fit_lindstrom_bates(const NonlinearModel& model,
                                    const VectorXd& start,
                                    const MixedEffectsOptions& options) {
  if (start.size() != model.coefficient_count()) {
    throw UsageError(fmt::format(
        "the start has {} values for {} coefficients", start.size(), model.coefficient_count()));
  }
  MixedEffectsFit fit;
  Obstacle obstacle;
  bool is_valid = false;
  {
    // The memory of the search is as large as the data, and not needed for the convergence test.
    const LindstromBatesSearch search = search_lindstrom_bates(model, start, options);
    is_valid = search.outcome.is_valid;
    if (model.specification().correlation) obstacle = search.outcome.obstacle;
    if (is_valid) fit = search.engine->result(search.outcome);
  }
  if (!is_valid) fit = failed(model, start, why_no_step(model, start));
  describe(model, fit);
  if (is_valid) judge(model, fit, Rounds::kAlternations, options.reml, obstacle);
  return fit;
}

}  // namespace silvafit::fit
