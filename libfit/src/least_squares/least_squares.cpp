// SPDX-License-Identifier: MIT
#include "silvafit/fit/least_squares.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "least_squares/exchanged_minima.hpp"
#include "least_squares/least_squares_polish.hpp"
#include "least_squares/least_squares_verdict.hpp"
#include "least_squares/levenberg_marquardt.hpp"
#include "least_squares/periodic_coefficients.hpp"
#include "least_squares/start_search.hpp"
#include "least_squares/variable_projection.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/fit_statistics.hpp"

namespace silvafit::fit {
namespace {

/// Sums of squares with a smaller relative difference belong to the same minimum.
constexpr double kSameMinimum = 1e-10;
/// From this number of observations on, descents begin on a sample.
constexpr Index kManyObservations = 20000;

bool has_sub_models(const NonlinearModel& model) {
  return std::ranges::any_of(model.specification().parameters, [](const ParameterModel& parameter) {
    return !parameter.covariates.empty();
  });
}

/// With very many observations, descents on a sample take little time and end near the minima of
/// all data. Their ends are the starts.
std::vector<VectorXd> nearer_starts(const NonlinearModel& model,
                                    const std::vector<VectorXd>& starts,
                                    const LeastSquaresOptions& options) {
  constexpr Index kSample = 4000;
  constexpr double kSameOnSample = 1e-6;
  /// A minimum that is higher by this factor on the sample is not the lowest on all data.
  constexpr double kHopeless = 1.5;
  const NonlinearModel part = model.subset(even_sample(model.response(), kSample));
  ProjectedModel projected(part);
  std::vector<Descent> reached;
  for (const VectorXd& start : starts) {
    Descent descent = descend(projected,
                              projected.nonlinear_part(start),
                              {.maximum_iterations = options.maximum_iterations});
    if (descent.coefficients.size() > 0) reached.push_back(std::move(descent));
  }
  std::ranges::stable_sort(reached, {}, &Descent::sum_of_squares);
  std::vector<VectorXd> result;
  double last = 0.0;
  for (const Descent& descent : reached) {
    if (descent.sum_of_squares > kHopeless * reached.front().sum_of_squares) break;
    if (!result.empty() && descent.sum_of_squares <= last * (1.0 + kSameOnSample)) continue;
    last = descent.sum_of_squares;
    result.push_back(descent.coefficients);
  }
  return result;
}

/// The lowest minimum that was found, and others.
struct Minima {
  Descent lowest{.sum_of_squares = kInfinity};
  std::vector<VectorXd> others{};  ///< (p) each, from low to high
};

/// The relative error of a sum of squares due to rounding of the nonlinear coefficients: with a
/// frequency of millions, the last digits change the mean.
double rounding_of(const ProjectedModel& projected, const Descent& descent) {
  constexpr double kLeast = 1e-8;
  constexpr double kDigits = 8.0 * std::numeric_limits<double>::epsilon();
  const MatrixXd jacobian = projected.model().curve_at(descent.coefficients).jacobian;
  const VectorXd nonlinear = projected.nonlinear_part(descent.coefficients);
  const double moved =
      kDigits * (jacobian(Eigen::all, projected.split().nonlinear) * nonlinear.asDiagonal()).norm();
  const double share = 2.0 * moved / std::sqrt(descent.sum_of_squares);
  return std::isfinite(share) ? std::max(kLeast, share) : kLeast;
}

/// Whether a minimum is preferred. If minima differ only by rounding, such as those of a frequency
/// on evenly spaced data, it is the one with the smaller coefficients.
bool is_preferred(const ProjectedModel& projected, const Descent& a, const Descent& b) {
  if (a.coefficients.size() == 0) return false;
  if (b.coefficients.size() == 0) return true;
  const bool is_smaller = projected.nonlinear_part(a.coefficients).squaredNorm() <
                          0.5 * projected.nonlinear_part(b.coefficients).squaredNorm();
  if (is_smaller && a.sum_of_squares <= b.sum_of_squares * (1.0 + rounding_of(projected, b))) {
    return true;
  }
  if (!(a.sum_of_squares < b.sum_of_squares * (1.0 - kSameMinimum))) return false;
  const bool is_larger = projected.nonlinear_part(b.coefficients).squaredNorm() <
                         0.5 * projected.nonlinear_part(a.coefficients).squaredNorm();
  return !is_larger || a.sum_of_squares < b.sum_of_squares * (1.0 - rounding_of(projected, a));
}

/// The minima that are not much higher than the lowest, each once.
std::vector<VectorXd> other_minima(std::vector<Descent> descents, const Descent& lowest) {
  constexpr double kMuchHigher = 2.0;
  constexpr double kSamePlace = 1e-3;
  std::ranges::stable_sort(descents, {}, &Descent::sum_of_squares);
  std::vector<VectorXd> result;
  const auto is_near = [&](const VectorXd& a, const VectorXd& b) {
    return ((a - b).array().abs() <= kSamePlace * b.array().abs()).all();
  };
  for (const Descent& descent : descents) {
    if (!(descent.sum_of_squares <= kMuchHigher * lowest.sum_of_squares)) break;
    const VectorXd& found = descent.coefficients;
    if (is_near(found, lowest.coefficients)) continue;
    if (std::ranges::any_of(result, [&](const VectorXd& o) { return is_near(found, o); })) continue;
    result.push_back(found);
  }
  return result;
}

/// Starts beyond the kinks around a minimum.
std::vector<VectorXd> starts_across_kinks(const NonlinearModel& model, const Descent& minimum) {
  if (minimum.coefficients.size() == 0 || model.kinks().empty()) return {};
  const NewtonPoint point = evidence_at(model, minimum.coefficients);
  const auto freedom = static_cast<double>(model.observations() - model.coefficient_count());
  if (!point.finite || !(freedom > 0.0)) return {};
  const VectorXd variances = point.unscaled_covariance.diagonal() * point.sum_of_squares / freedom;
  return points_across_kinks(model, minimum.coefficients, variances.cwiseSqrt());
}

/// The best of several descents on all data: each has some iterations, and the best continues.
Minima minima_from(ProjectedModel& projected,
                   const std::vector<VectorXd>& starts,
                   const LeastSquaresOptions& options) {
  constexpr int kTrial = 30;
  Minima result;
  Descent& best = result.lowest;
  int iterations = 0;
  std::vector<Descent> descents;
  const auto descend_from = [&](const VectorXd& start, int limit) {
    Descent descent =
        descend(projected, projected.nonlinear_part(start), {.maximum_iterations = limit});
    iterations += descent.iterations;
    if (is_preferred(projected, descent, best)) best = descent;
    if (descent.coefficients.size() > 0) descents.push_back(std::move(descent));
  };
  for (const VectorXd& start : starts) {
    descend_from(start, std::min(kTrial, options.maximum_iterations));
  }
  if (best.iterations >= kTrial) {
    descend_from(VectorXd(best.coefficients), options.maximum_iterations - kTrial);
  }
  // Each better minimum has others around it.
  constexpr int kRoundsAcross = 4;
  for (int round = 0; round < kRoundsAcross; ++round) {
    std::vector<VectorXd> beyond = starts_across_kinks(projected.model(), best);
    if (!beyond.empty() && projected.model().observations() >= kManyObservations) {
      beyond = nearer_starts(projected.model(), beyond, options);
    }
    const double before = best.sum_of_squares;
    for (const VectorXd& start : beyond) {
      descend_from(start, std::min(kTrial, options.maximum_iterations));
    }
    if (!(best.sum_of_squares < before * (1.0 - kSameMinimum))) break;
  }
  best.iterations = iterations;
  if (options.other_minima) result.others = other_minima(std::move(descents), best);
  return result;
}

Minima minima(ProjectedModel& projected,
              const std::vector<VectorXd>& starts,
              const LeastSquaresOptions& options) {
  const NonlinearModel& model = projected.model();
  if (model.observations() >= kManyObservations) {
    Minima result = minima_from(projected, nearer_starts(model, starts, options), options);
    // Nothing if the mean is finite on the sample but not on all data.
    if (result.lowest.coefficients.size() > 0) return result;
  }
  return minima_from(projected, starts, options);
}

/// Of minima that are mirror images of each other, as (a, b) and (-a, -b) in Naslund's curve, the
/// one with positive coefficients.
void prefer_positive(ProjectedModel& projected, Descent& minimum) {
  const auto try_point = [&](const VectorXd& nonlinear) {
    if (!projected.evaluate(nonlinear)) return;
    const double sum_of_squares = projected.residuals().squaredNorm();
    if (sum_of_squares > minimum.sum_of_squares * (1.0 + kSameMinimum)) return;
    minimum.coefficients = projected.coefficients();
    minimum.sum_of_squares = sum_of_squares;
  };
  const VectorXd all = projected.nonlinear_part(minimum.coefficients);
  if ((all.array() < 0.0).any()) try_point(all.cwiseAbs());
  for (Index k = 0; k < projected.size(); ++k) {
    VectorXd one = projected.nonlinear_part(minimum.coefficients);
    if (one[k] >= 0.0) continue;
    one[k] = -one[k];
    try_point(one);
  }
}

Minima solve(const NonlinearModel& model, const LeastSquaresOptions& options);

/// Starts for a model with covariates from the fit without them, so that it cannot be worse.
std::vector<VectorXd> starts_from_pooled(const NonlinearModel& model,
                                         const LeastSquaresOptions& options) {
  const NonlinearModel pooled = model.pooled();
  Minima constants = solve(pooled, options);
  if (constants.lowest.coefficients.size() == 0) return {};
  std::vector<VectorXd> starts{std::move(constants.lowest.coefficients)};
  std::ranges::move(constants.others, std::back_inserter(starts));
  for (VectorXd& start : starts) {
    start = spread_constants(model, pooled, start);
    for (const auto& [name, value] : options.start) {
      const auto& names = model.coefficient_names();
      const auto found = std::ranges::find(names, name);
      if (found != names.end()) start[found - names.begin()] = value;
    }
  }
  return starts;
}

/// The minima of the sum of squares that are reached from all starts.
Minima solve(const NonlinearModel& model, const LeastSquaresOptions& options) {
  constexpr std::size_t kStarts = 3;
  constexpr std::size_t kStartsForOthers = 6;
  ProjectedModel projected(model);
  const bool has_covariates = has_sub_models(model);
  std::vector<VectorXd> starts;
  if (has_covariates) starts = starts_from_pooled(model, options);
  // A frequency of the residuals may differ from that of the fit without covariates, and kinks may
  // be elsewhere.
  if (!has_covariates || !periodic_coefficients(model).empty() || !model.kinks().empty()) {
    std::ranges::move(search_starts(model,
                                    {.fixed = options.start,
                                     .rule = options.rule,
                                     .count = options.other_minima ? kStartsForOthers : kStarts,
                                     .further_hops = options.further_starts}),
                      std::back_inserter(starts));
  }
  Minima result = minima(projected, starts, options);
  for (const PeriodicCoefficient& periodic : periodic_coefficients(model)) {
    std::erase_if(result.others, [&](const VectorXd& found) {
      return !periodic.contains(found[periodic.coefficient]);
    });
  }
  Descent& lowest = result.lowest;
  if (lowest.coefficients.size() == 0) return result;
  lowest.coefficients = with_usual_phases(model, lowest.coefficients);
  for (VectorXd& other : result.others) other = with_usual_phases(model, other);
  prefer_positive(projected, lowest);
  if (options.other_minima && !has_covariates) {
    std::vector<VectorXd> exchanged = exchanged_minima(model, lowest.coefficients);
    std::ranges::move(exchanged_locations(model, lowest.coefficients),
                      std::back_inserter(exchanged));
    result.others.insert(result.others.begin(), exchanged.begin(), exchanged.end());
  }
  return result;
}

LeastSquaresFit empty_fit(const NonlinearModel& model) {
  const Index p = model.coefficient_count();
  LeastSquaresFit fit;
  fit.coefficient_names = model.coefficient_names();
  fit.estimate = VectorXd::Constant(p, kNaN);
  fit.covariance = MatrixXd::Constant(p, p, kNaN);
  fit.sum_of_squares = fit.sigma = fit.log_likelihood = kNaN;
  fit.parameter_count = static_cast<int>(p) + 1;
  fit.observations = model.observations();
  fit.fitted = VectorXd::Constant(model.observations(), kNaN);
  return fit;
}

/// A model whose coefficients are all held.
LeastSquaresFit evaluated(const NonlinearModel& model) {
  LeastSquaresFit fit = empty_fit(model);
  fit.fitted = model.mean_at(fit.estimate);
  if (!fit.fitted.allFinite()) {
    fit.convergence = no_start();
    return fit;
  }
  fit.sum_of_squares = (model.response() - fit.fitted).squaredNorm();
  fit.sigma = std::sqrt(fit.sum_of_squares / fit.residual_degrees_of_freedom());
  fit.log_likelihood = is_exact(model, fit.sum_of_squares)
                           ? kInfinity
                           : least_squares_log_likelihood(fit.sum_of_squares, fit.observations);
  fit.convergence = {.status = ConvergenceStatus::kConverged,
                     .findings = {{.kind = Finding::Kind::kAllHeld}}};
  return fit;
}

/// If a coefficient reaches a limit of the formula, its steps fail and prevent the others from
/// converging. Each is held in turn, so that the others can converge.
NewtonPoint finish_the_others(const NonlinearModel& model,
                              const NewtonPoint& stuck,
                              const LeastSquaresOptions& options) {
  // Each takes a descent; of very many, most are contrasts of factors, which have no such limits.
  constexpr int kMost = 20;
  ProjectedModel projected(model);
  NewtonPoint best = stuck;
  if (projected.size() < 2 || projected.size() > kMost) return best;
  for (int held = 0; held < projected.size(); ++held) {
    const Descent descent =
        descend(projected,
                projected.nonlinear_part(best.coefficients),
                {.maximum_iterations = options.maximum_iterations, .held = held});
    if (descent.sum_of_squares >= best.sum_of_squares) continue;
    const int iterations = best.iterations + descent.iterations;
    best = refine(model, descent.coefficients);
    best.iterations += iterations;
  }
  return best;
}

LeastSquaresFit described(const NonlinearModel& model,
                          const Descent& minimum,
                          const LeastSquaresOptions& options) {
  NewtonPoint point = refine(model, minimum.coefficients);
  if (!is_converged(point)) point = finish_the_others(model, point, options);
  if (!is_converged(point) && !model.kinks().empty()) {
    if (auto at_kinks = minimum_at_kinks(model, point)) point = *std::move(at_kinks);
  }
  LeastSquaresFit fit = empty_fit(model);
  fit.estimate = point.coefficients;
  fit.fitted = point.mean;
  fit.sum_of_squares = point.sum_of_squares;
  const bool exact = is_exact(model, point.sum_of_squares);
  const double freedom = fit.residual_degrees_of_freedom();
  if (freedom > 0.0) fit.sigma = std::sqrt(point.sum_of_squares / freedom);
  fit.log_likelihood =
      exact ? kInfinity : least_squares_log_likelihood(point.sum_of_squares, fit.observations);
  if (point.finite) fit.covariance = fit.sigma * fit.sigma * point.unscaled_covariance;
  fit.convergence = judge(model, point, exact);
  fit.convergence.iterations = minimum.iterations + point.iterations;
  return fit;
}

/// The fit from given start values with the minima that a search without them finds.
LeastSquaresFit with_other_minima(LeastSquaresFit fit,
                                  const NonlinearModel& model,
                                  LeastSquaresOptions options) {
  if (!options.other_minima) return fit;
  options.start.clear();
  Minima found = solve(model, options);
  if (found.lowest.coefficients.size() > 0) {
    fit.other_minima.push_back(std::move(found.lowest.coefficients));
  }
  std::ranges::move(found.others, std::back_inserter(fit.other_minima));
  return fit;
}

}  // namespace

VectorXd spread_constants(const NonlinearModel& model,
                          const NonlinearModel& pooled,
                          const VectorXd& constants) {
  VectorXd coefficients = VectorXd::Zero(model.coefficient_count());
  const MatrixXd weights = pooled.curve_at(constants).jacobian;
  for (Index k = 0; k < constants.size(); ++k) {
    std::vector<Index> members = model.design().coefficients_of(k);
    std::erase_if(members, [&](Index j) { return j >= coefficients.size(); });
    if (model.specification().parameters[static_cast<std::size_t>(k)].has_intercept) {
      coefficients[members.front()] = constants[k];
      continue;
    }
    MatrixXd covariates(model.observations(), static_cast<Index>(members.size()));
    for (Index j = 0; j < covariates.cols(); ++j) {
      model.design().differentiate(members[static_cast<std::size_t>(j)],
                                   0,
                                   covariates.rows(),
                                   weights.col(k).data(),
                                   covariates.col(j).data());
    }
    coefficients(members) = covariates.colPivHouseholderQr().solve(weights.col(k) * constants[k]);
  }
  return coefficients;
}

double LeastSquaresFit::residual_degrees_of_freedom() const {
  return static_cast<double>(observations - estimate.size());
}

LeastSquaresFit fit_least_squares(const NonlinearModel& model, const LeastSquaresOptions& options) {
  if (model.coefficient_count() == 0) return evaluated(model);
  if (model.observations() < model.coefficient_count()) {
    LeastSquaresFit fit = empty_fit(model);
    fit.convergence = too_few_observations(model);
    return fit;
  }
  const std::vector<VectorXd> given = complete_starts(model, options.start);
  if (!given.empty()) {
    ProjectedModel projected(model);
    Descent minimum = descend(projected,
                              projected.nonlinear_part(given.front()),
                              {.maximum_iterations = options.maximum_iterations});
    if (minimum.coefficients.size() > 0) {
      minimum.coefficients = nearest_minimum(model, minimum.coefficients, given.front());
      LeastSquaresFit fit = described(model, minimum, options);
      if (fit.convergence.converged()) return with_other_minima(std::move(fit), model, options);
    }
  }
  Minima found = solve(model, options);
  const Descent& minimum = found.lowest;
  if (minimum.coefficients.size() == 0) {
    check_domain(model);
    LeastSquaresFit fit = empty_fit(model);
    fit.convergence = no_start();
    return fit;
  }
  LeastSquaresFit fit = described(model, minimum, options);
  if (!fit.covariance.diagonal().array().isFinite().any()) check_domain(model);
  fit.other_minima = std::move(found.others);
  return fit;
}

}  // namespace silvafit::fit
