// SPDX-License-Identifier: MIT
#include "silvafit/fit/mixed_effects.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lindstrom_bates.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Two log-likelihoods that differ by less are the same but for rounding.
constexpr double kSameLikelihood = 1e-7;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Random effects whose spread is nothing beside what one standard error of the residuals would
/// move.
std::vector<std::string> vanished_effects(const MixedEffectsFit& fit, const VectorXd& mean_slope) {
  constexpr double kShareOfSigma = 1e-4;
  std::vector<std::string> names;
  const VectorXd deviations = fit.random_sd();
  for (Index k = 0; k < deviations.size(); ++k) {
    const double effect = deviations[k] * mean_slope[k];
    if (effect < kShareOfSigma * fit.residual_sd.mean()) {
      names.push_back(fmt::format("sd({}) = 0", fit.random_names[static_cast<std::size_t>(k)]));
    }
  }
  return names;
}

/// Correlations that have run to one, or a dependence among three or more.
std::vector<std::string> dependent_effects(const MixedEffectsFit& fit) {
  constexpr double kTiny = 1e-6;
  std::vector<std::string> names;
  const MatrixXd correlation = fit.random_correlation();
  if (!correlation.allFinite() || correlation.rows() < 2) return names;
  for (Index i = 0; i < correlation.rows(); ++i) {
    for (Index j = 0; j < i; ++j) {
      if (1.0 - std::abs(correlation(i, j)) > kTiny) continue;
      names.push_back(fmt::format("cor({}, {}) = {}",
                                  fit.random_names[static_cast<std::size_t>(j)],
                                  fit.random_names[static_cast<std::size_t>(i)],
                                  correlation(i, j) > 0 ? 1 : -1));
    }
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(correlation);
  if (names.empty() && solver.eigenvalues()[0] < kTiny) {
    names.push_back(fmt::format("the random effects {} depend linearly on each other",
                                fmt::join(fit.random_names, ", ")));
  }
  return names;
}

/// Root mean square of the derivatives by the random coefficients.
VectorXd mean_slopes(const NonlinearModel& model, const MixedEffectsFit& fit) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd jacobian;
  model.evaluate(fit.estimate, mean, &jacobian, workspace);
  VectorXd slopes(static_cast<Index>(fit.random_names.size()));
  for (std::size_t k = 0; k < fit.random_names.size(); ++k) {
    const auto column = jacobian.col(model.coefficient_index(fit.random_names[k]));
    slopes[static_cast<Index>(k)] =
        std::sqrt(column.squaredNorm() / static_cast<double>(column.size()));
  }
  return slopes;
}

void name_boundary(const NonlinearModel& model, MixedEffectsFit& fit) {
  std::vector<std::string>& boundary = fit.convergence.boundary;
  boundary = vanished_effects(fit, mean_slopes(model, fit));
  if (boundary.empty()) boundary = dependent_effects(fit);
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    if (factor.factor.constant) continue;
    if (factor.constant.array().isInf().any()) boundary.emplace_back("the variance is constant");
    if ((factor.constant.array() < 1e-8).any()) {
      boundary.emplace_back("the constant of the variance function = 0");
    }
  }
}

/// Coefficients that the data cannot tell apart, from the information matrix at the optimum.
int information_rank(const MixedEffectsFit& fit) {
  const VectorXd deviations = fit.covariance.diagonal().cwiseSqrt();
  if (!deviations.allFinite() || deviations.minCoeff() <= 0.0) return 0;
  const MatrixXd correlation = deviations.cwiseInverse().asDiagonal() * fit.covariance *
                               deviations.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(correlation);
  constexpr double kConfounded = 1e-12;
  return static_cast<int>(
      (solver.eigenvalues().array() > kConfounded * solver.eigenvalues().maxCoeff()).count());
}

std::string verdict_of(const MixedEffectsFit& fit) {
  const Convergence& convergence = fit.convergence;
  if (!convergence.converged) {
    return fmt::format(
        "Not converged after {} alternations: the variance components still move by {:.2g} "
        "standard "
        "errors. Try fewer random effects or a diagonal covariance.",
        convergence.iterations,
        std::sqrt(std::max(0.0, convergence.gradient)));
  }
  if (convergence.rank < fit.estimate.size()) {
    return "Converged, but the data cannot tell all coefficients apart: their estimates depend "
           "linearly on "
           "each other. Drop a covariate or a parameter.";
  }
  std::string verdict = fmt::format(
      "Converged after {} alternations: the next would move nothing by more than {:.0e} standard "
      "errors.",
      convergence.iterations,
      std::max(1e-9, std::sqrt(std::max(0.0, convergence.gradient))));
  if (!convergence.boundary.empty()) {
    verdict += fmt::format(" On the edge: {}; a simpler structure says the same.",
                           fmt::join(convergence.boundary, "; "));
  }
  if (fit.floored_variances > 0) {
    verdict += fmt::format(
        " {} fitted values are too near zero for a power variance and were floored; "
        "constant-plus-power may suit better.",
        fit.floored_variances);
  }
  return verdict;
}

/// Why penalised least squares found no first step.
std::string why_no_step(const NonlinearModel& model, const VectorXd& start) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd jacobian;
  model.evaluate(start, mean, &jacobian, workspace);
  for (Index j = 0; j < jacobian.cols(); ++j) jacobian.col(j).normalize();
  const Eigen::ColPivHouseholderQR<MatrixXd> solver(jacobian);
  if (jacobian.allFinite() && solver.rank() < jacobian.cols()) {
    const Index last = solver.colsPermutation().indices()[jacobian.cols() - 1];
    return fmt::format(
        "Not converged: the data cannot tell {} apart from the other coefficients. Drop it, or "
        "what "
        "it depends on.",
        model.coefficient_names()[static_cast<std::size_t>(last)]);
  }
  return "Not converged: the first penalised least-squares step found no finite point. Try fewer "
         "random effects, or a model that the pooled data fit better.";
}

MixedEffectsFit failed(const NonlinearModel& model, const VectorXd& start, std::string verdict) {
  const auto q = model.specification().random
                     ? static_cast<Index>(model.specification().random->coefficients.size())
                     : 0;
  MixedEffectsFit fit;
  fit.estimate = start;
  fit.covariance = MatrixXd::Constant(start.size(), start.size(), kNaN);
  fit.random_covariance = MatrixXd::Constant(q, q, kNaN);
  fit.random_effects = MatrixXd::Constant(q, model.group_count(), kNaN);
  fit.sigma = kNaN;
  fit.log_likelihood = kNaN;
  fit.observations = model.observations();
  fit.fitted_population = VectorXd::Constant(model.observations(), kNaN);
  fit.fitted_conditional = fit.fitted_population;
  fit.residual_sd = fit.fitted_population;
  fit.variance = VarianceEstimate::missing(model.specification().variance);
  fit.convergence.verdict = std::move(verdict);
  return fit;
}

/// The log-likelihood of the start without random effects, which every mixed model contains.
double pooled_log_likelihood(const NonlinearModel& model, const VectorXd& start) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  model.evaluate(start, mean, nullptr, workspace);
  return least_squares_log_likelihood((model.response() - mean).squaredNorm(),
                                      model.observations());
}

/// One run, and further ones from inside if it stopped on the edge while the likelihood rises
/// inwards.
LindstromBatesOutcome run_from(LindstromBates& engine,
                               const LindstromBatesState& start,
                               int maximum_iterations) {
  LindstromBatesOutcome outcome = engine.run(start, maximum_iterations);
  LindstromBatesState inside;
  constexpr int kAttempts = 3;
  for (int attempt = 0; attempt < kAttempts && engine.leave_edge(outcome, inside); ++attempt) {
    LindstromBatesOutcome moved = engine.run(inside, maximum_iterations);
    if (!moved.is_valid || moved.log_likelihood <= outcome.log_likelihood + kSameLikelihood) break;
    outcome = std::move(moved);
  }
  return outcome;
}

bool is_better(const LindstromBatesOutcome& a, const LindstromBatesOutcome& b) {
  if (!a.is_valid || !b.is_valid) return a.is_valid;
  if (a.converged != b.converged) return a.converged;
  return a.log_likelihood > b.log_likelihood + kSameLikelihood;
}

/// The best of several runs; a run counts as converged only above the pooled fit.
class Search {
 public:
  Search(LindstromBates& engine, double pooled, int maximum_iterations)
      : engine_(engine), pooled_(pooled), maximum_iterations_(maximum_iterations) {}

  void consider(const LindstromBatesState& start) {
    LindstromBatesOutcome outcome = run_from(engine_, start, maximum_iterations_);
    outcome.converged = outcome.converged && outcome.log_likelihood > pooled_ - kSameLikelihood;
    if (is_better(outcome, best_)) best_ = std::move(outcome);
  }

  /// From the first-order start, then from spreads of the random effects from wide to narrow, the
  /// narrow ones again with patience. A narrow start keeps groups that are far from the pooled fit
  /// from running into mirror images of their curves in the first step.
  void try_all_starts() {
    constexpr int kImpatient = 6;
    constexpr int kPatient = 100;
    engine_.set_patience(kImpatient);
    consider(engine_.first_order_start());
    if (best_.converged) return;
    for (const double spread : {1.0, 0.1, 0.01, 0.001}) consider(engine_.start(spread));
    if (best_.converged) return;
    engine_.set_patience(kPatient);
    for (const double spread : {0.1, 0.01}) consider(engine_.start(spread));
  }

  const LindstromBatesOutcome& best() const { return best_; }

 private:
  LindstromBates& engine_;
  double pooled_;
  int maximum_iterations_;
  LindstromBatesOutcome best_;
};

/// Without a variance function, all starts. With one, from the fit with constant variance, which it
/// contains, and from a start of its own; all starts if neither converges.
LindstromBatesOutcome best_outcome(LindstromBates& engine, double pooled, int maximum_iterations) {
  Search search(engine, pooled, maximum_iterations);
  if (engine.has_variance_function()) {
    engine.hold_variance(true);
    Search constant(engine, pooled, maximum_iterations);
    constant.try_all_starts();
    engine.hold_variance(false);
    search.consider(engine.first_order_start());
    if (constant.best().is_valid) {
      search.consider(engine.with_free_variance(constant.best().state));
    }
    if (search.best().converged) return search.best();
  }
  search.try_all_starts();
  return search.best();
}

}  // namespace

double MixedEffectsFit::aic() const { return fit::aic(log_likelihood, parameter_count); }
double MixedEffectsFit::aicc() const {
  return fit::aicc(log_likelihood, parameter_count, observations);
}
double MixedEffectsFit::bic() const {
  return fit::bic(log_likelihood, parameter_count, observations);
}

VectorXd MixedEffectsFit::standard_errors() const { return covariance.diagonal().cwiseSqrt(); }
VectorXd MixedEffectsFit::random_sd() const { return random_covariance.diagonal().cwiseSqrt(); }

MatrixXd MixedEffectsFit::random_correlation() const {
  const VectorXd deviations = random_sd();
  MatrixXd correlation = random_covariance;
  for (Index i = 0; i < correlation.rows(); ++i) {
    for (Index j = 0; j < correlation.cols(); ++j) {
      const double product = deviations[i] * deviations[j];
      correlation(i, j) = i == j ? 1.0 : (product > 0.0 ? correlation(i, j) / product : kNaN);
    }
  }
  return correlation;
}

MixedEffectsFit fit_lindstrom_bates(const NonlinearModel& model,
                                    const VectorXd& start,
                                    const MixedEffectsOptions& options) {
  if (start.size() != model.coefficient_count()) {
    throw UsageError(fmt::format(
        "the start has {} values for {} coefficients", start.size(), model.coefficient_count()));
  }
  LindstromBates engine(model, start);
  const LindstromBatesOutcome outcome =
      best_outcome(engine, pooled_log_likelihood(model, start), options.maximum_iterations);
  MixedEffectsFit fit =
      outcome.is_valid ? engine.result(outcome) : failed(model, start, why_no_step(model, start));
  fit.coefficient_names = model.coefficient_names();
  fit.group_labels = model.group_labels();
  if (model.specification().random) fit.random_names = model.specification().random->coefficients;
  // nlme's count: observations less groups less coefficients, the first of which the groups absorb.
  const auto groups = model.specification().random ? static_cast<double>(model.group_count()) : 1.0;
  fit.degrees_of_freedom =
      static_cast<double>(model.observations()) - groups - static_cast<double>(start.size() - 1);
  if (outcome.is_valid) {
    fit.convergence.rank = information_rank(fit);
    name_boundary(model, fit);
    fit.convergence.verdict = verdict_of(fit);
  }
  return fit;
}

}  // namespace silvafit::fit
