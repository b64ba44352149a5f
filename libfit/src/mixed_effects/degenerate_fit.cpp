// SPDX-License-Identifier: MIT
#include "mixed_effects/degenerate_fit.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "mixed_effects/boundary.hpp"
#include "model/symmetric_eigen.hpp"
#include "result/group_coefficients.hpp"
#include "verdict/thresholds.hpp"

namespace silvafit::fit {
namespace {

/// Standard deviation of the response, or its size if it is constant.
double spread_of(const VectorXd& response) {
  const auto n = static_cast<double>(response.size());
  const double spread = (response.array() - response.mean()).matrix().norm() / std::sqrt(n);
  return spread > 0.0 ? spread : std::abs(response.mean());
}

constexpr double kSmallest = std::numeric_limits<double>::min();  ///< instead of a length of 0

double typical_residual(const MixedEffectsFit& fit) {
  return fit.residual_sd.norm() / std::sqrt(static_cast<double>(fit.residual_sd.size()));
}

double actual_residual(const NonlinearModel& model, const MixedEffectsFit& fit) {
  const VectorXd residuals = model.response() - fit.fitted_conditional;
  return residuals.norm() / std::sqrt(static_cast<double>(residuals.size()));
}

/// Strata whose residuals have gone to 0 although the random effects leave some of them, so that
/// the likelihood increases without bound.
std::vector<std::string> vanishing_strata(const NonlinearModel& model,
                                          const MixedEffectsFit& fit,
                                          double spread) {
  std::vector<std::string> result;
  // What the effects leave of correlated residuals is not known.
  if (fit.variance.correlation) return result;
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    if (factor.factor.stratum.empty()) continue;
    const NonlinearModel::Strata& strata = model.strata(factor.factor.stratum);
    VectorXd largest = VectorXd::Zero(std::ssize(strata.labels));
    for (std::size_t i = 0; i < strata.of_rows.size(); ++i) {
      double& own = largest[strata.of_rows[i]];
      own = std::max(own, fit.residual_sd[static_cast<Index>(i)]);
    }
    for (std::size_t s = 0; s < strata.labels.size(); ++s) {
      const bool is_zero = largest[static_cast<Index>(s)] < Thresholds::kRoundedResidual * spread;
      const bool is_known = std::ranges::find(result, strata.labels[s]) != result.end();
      if (is_zero && !is_known) result.push_back(strata.labels[s]);
    }
  }
  if (result.empty()) return result;
  for (const std::string& by_effects : strata_without_residuals(model, fit)) {
    std::erase(result, by_effects);
  }
  return result;
}

/// Whether the random effects of the last term alone can fit all rows; of crossed ones, if it has a
/// group for each row.
bool can_fit_all_rows(const NonlinearModel& model) {
  const std::vector<RandomEffects>& terms = model.specification().random;
  if (terms.empty()) return false;
  if (model.crossed() != nullptr) {
    return model.group_count(model.term_count() - 1) == model.observations();
  }
  const auto effects = static_cast<Index>(terms.back().coefficients.size());
  for (Index group = 0; group < model.group_count(); ++group) {
    if (model.group_begin(group + 1) - model.group_begin(group) > effects) return false;
  }
  return true;
}

std::optional<Finding> exactness(const NonlinearModel& model,
                                 const MixedEffectsFit& fit,
                                 double spread) {
  const double residual = typical_residual(fit);
  if (residual < Thresholds::kNothingLeft * spread && can_fit_all_rows(model)) {
    return Finding{.kind = Finding::Kind::kSmallGroupsExact,
                   .names = {model.specification().random.back().group}};
  }
  // A search that approaches a standard deviation of 0 may stop before, with residuals near 0.
  const double smallest = std::min(residual, actual_residual(model, fit));
  if (smallest < Thresholds::kRoundedResidual * spread) {
    return Finding{.kind = Finding::Kind::kPerfectCurve};
  }
  std::vector<std::string> strata = vanishing_strata(model, fit, spread);
  if (!strata.empty())
    return Finding{.kind = Finding::Kind::kVanishingStratum, .names = std::move(strata)};
  const auto& correlation = fit.variance.correlation;
  if (!correlation || least_variance(*correlation) > Thresholds::kDependent) return std::nullopt;
  return Finding{.kind = Finding::Kind::kSingularCorrelation,
                 .names = {correlation->correlation.text()}};
}

/// The curves of the population and of groups with effects in one direction.
class Curves {
 public:
  Curves(const NonlinearModel& model, const VectorXd& estimate)
      : model_(model),
        estimate_(model.extended(estimate)),
        population_(at(VectorXd::Zero(estimate_.size()))) {}

  VectorXd at(const VectorXd& shift) const { return model_.mean_at(estimate_ + shift); }

  /// The median distance of two curves over the rows, without rows outside the domain.
  static double distance(const VectorXd& a, const VectorXd& b) {
    std::vector<double> distances;
    for (Index i = 0; i < a.size(); ++i) {
      const double distance = std::abs(a[i] - b[i]);
      if (!std::isnan(distance)) distances.push_back(distance);
    }
    if (distances.empty()) return 0.0;
    const auto middle = distances.begin() + std::ssize(distances) / 2;
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle;
  }

  /// Whether one standard deviation changes the curve by less than the spread of the response on
  /// either side. This holds for nearly all models and makes further tests unnecessary.
  bool is_ordinary(const VectorXd& shift, double spread) const {
    return is_near(at(shift), spread) && is_near(at(-shift), spread);
  }

  bool is_beyond_measure(const VectorXd& shift, double spread) const {
    return std::ranges::any_of(std::vector{2.0, -2.0}, [&](double size) {
      return distance(at(size * shift), population_) > Thresholds::kBeyondMeasure * spread;
    });
  }

  /// Whether one and two standard deviations give the same curve on either side, and the sides
  /// differ.
  bool is_saturated(const VectorXd& shift, double spread) const {
    const VectorXd above = at(shift);
    const VectorXd below = at(-shift);
    return distance(above, below) > Thresholds::kTwoSides * spread &&
           distance(at(2.0 * shift), above) < Thresholds::kSame * spread &&
           distance(at(-2.0 * shift), below) < Thresholds::kSame * spread;
  }

 private:
  /// Whether the median distance from the population's curve is less than a limit, computed without
  /// the median.
  bool is_near(const VectorXd& curve, double length) const {
    const auto distances = (curve - population_).array().abs();
    const Index near = (distances < length).count();
    const Index missing = distances.isNaN().count();
    const Index measured = curve.size() - missing;
    return measured == 0 ? length > 0.0 : near > measured / 2;
  }

  const NonlinearModel& model_;
  VectorXd estimate_;
  VectorXd population_;
};

/// The random effects of one term.
struct EffectLevel {
  const std::vector<std::string>& names;
  const MatrixXd& covariance;
  const MatrixXd& frame;
  std::vector<Index> places{};
};

/// "sd(a)", or those of several effects that diverge together.
std::vector<std::string> names_of(const EffectLevel& level, const VectorXd& direction) {
  const VectorXd size = direction.cwiseAbs().cwiseQuotient(level.frame.diagonal());
  std::vector<std::string> names;
  for (Index k = 0; k < size.size(); ++k) {
    if (size[k] < Thresholds::kShare * size.maxCoeff()) continue;
    names.push_back(fmt::format("sd({})", level.names[static_cast<std::size_t>(k)]));
  }
  return names;
}

Degeneracy unbounded(std::vector<std::string> names, Finding::Kind why) {
  Degeneracy result;
  for (const std::string& name : names) {
    result.evidence.push_back({.kind = Evidence::Kind::kUnbounded, .term = name});
  }
  result.reason = {.kind = why, .names = std::move(names)};
  return result;
}

/// The principal component of the effects of a grouping along which the curve degenerates, if any.
Degeneracy unbounded_effect(const EffectLevel& level,
                            const Curves& curves,
                            Index p,
                            double spread) {
  if (level.places.empty() || !level.covariance.allFinite()) return {};
  const auto frame = level.frame.triangularView<Eigen::Lower>();
  const MatrixXd half = frame.solve(level.covariance);
  const SymmetricEigen of = symmetric_eigen(frame.solve(half.transpose()));
  for (Index k = 0; k < of.values.size(); ++k) {
    const VectorXd direction =
        level.frame * of.vectors.col(k) * std::sqrt(std::max(0.0, of.values[k]));
    VectorXd shift = VectorXd::Zero(p);
    shift(level.places) = direction;
    if (curves.is_ordinary(shift, spread)) continue;
    if (curves.is_beyond_measure(shift, spread)) {
      return unbounded(names_of(level, direction), Finding::Kind::kBeyondMeasure);
    }
    if (curves.is_saturated(shift, spread)) {
      return unbounded(names_of(level, direction), Finding::Kind::kSaturated);
    }
  }
  return {};
}

/// Variances of the effects of a term, given those of coefficients with random effects only, whose
/// mean is known: they tell something of the means of the others.
VectorXd open_variances(const EffectLevel& level, Index p) {
  std::vector<Index> known;
  for (std::size_t k = 0; k < level.places.size(); ++k) {
    if (level.places[k] >= p) known.push_back(static_cast<Index>(k));
  }
  VectorXd result = level.covariance.diagonal();
  if (known.empty()) return result;
  const MatrixXd cross = level.covariance(known, Eigen::all);
  const MatrixXd own = level.covariance(known, known);
  const MatrixXd solved = own.completeOrthogonalDecomposition().solve(cross);
  return result - cross.cwiseProduct(solved).colwise().sum().transpose();
}

/// A coefficient with a smaller standard error than its random effect allows, if any. The standard
/// error of the mean of G groups with standard deviation s is at least s/sqrt(G); the inverse of a
/// nearly singular information matrix may have smaller ones.
Degeneracy impossible_error(const NonlinearModel& model,
                            const MixedEffectsFit& fit,
                            const EffectLevel& level,
                            Index groups) {
  // Without a maximum, the curvature is not an information matrix.
  if (fit.covariance.size() == 0 || !fit.convergence.converged()) return {};
  const VectorXd variances = open_variances(level, fit.estimate.size());
  for (std::size_t k = 0; k < level.places.size(); ++k) {
    const Index j = level.places[k];
    if (j >= fit.estimate.size()) continue;
    const double variance = variances[static_cast<Index>(k)];
    const double least = std::sqrt(variance / static_cast<double>(std::max<Index>(1, groups)));
    const double error = std::sqrt(fit.covariance(j, j));
    if (model.design().multiplier(j) != nullptr || !(error < Thresholds::kImpossible * least))
      continue;
    return {.status = ConvergenceStatus::kNotIdentifiable,
            .evidence = {{.kind = Evidence::Kind::kHardlyIdentifiable,
                          .term = level.names[k],
                          .value = error}},
            .reason = Finding{.kind = Finding::Kind::kImpossibleError,
                              .names = {level.names[k]},
                              .values = {static_cast<double>(groups), std::sqrt(variance), error}}};
  }
  return {};
}

/// Whether the likelihood has no bound as the standard deviation of a stratum of n rows goes to 0:
/// with effects b of some terms, a curve X beta + Z b passes through all of its rows, for which the
/// rank of [X Z] must be n, and the covariance of its rows becomes singular, for which that of Z
/// must be less. If the effects alone have the rank n, the likelihood has a limit.
class StratumRanks {
 public:
  StratumRanks(const NonlinearModel& model, MatrixXd jacobian)
      : model_(model), jacobian_(std::move(jacobian)), cell_of_(jacobian_.rows()) {
    const VectorXd lengths = jacobian_.colwise().norm().cwiseMax(kSmallest);
    jacobian_ *= lengths.cwiseInverse().asDiagonal();
    for (Index cell = 0; cell < model.group_count(); ++cell) {
      const Index begin = model.group_begin(cell);
      cell_of_.segment(begin, model.group_begin(cell + 1) - begin).setConstant(cell);
    }
  }

  bool are_known() const { return jacobian_.allFinite(); }

  bool can_vanish(const std::vector<Index>& rows, PassingEffects which) const {
    constexpr Index kLargest = 1000;  // of dense matrices
    if (rows.empty() || std::ssize(rows) > kLargest) return false;
    const MatrixXd fixed = jacobian_(rows, Eigen::seqN(0, model_.coefficient_count()));
    MatrixXd effects(fixed.rows(), 0);
    for (std::size_t t = 0;; ++t) {
      const bool has_all = t == model_.term_count();
      const bool is_wanted = has_all || which == PassingEffects::kSome;
      if (is_wanted && is_passed(fixed, effects)) return true;
      if (has_all) return false;
      add_effects(t, rows, effects);
    }
  }

 private:
  static Index rank(const MatrixXd& of) {
    return of.cols() == 0 ? 0 : of.colPivHouseholderQr().rank();
  }

  static bool is_passed(const MatrixXd& fixed, const MatrixXd& effects) {
    if (fixed.rows() > fixed.cols() + effects.cols()) return false;
    MatrixXd both(fixed.rows(), fixed.cols() + effects.cols());
    both << fixed, effects;
    return rank(both) == fixed.rows() && rank(effects) < fixed.rows();
  }

  /// Appends the columns of the groups of a term that have some of the rows.
  void add_effects(std::size_t term, const std::vector<Index>& rows, MatrixXd& effects) const {
    const std::vector<Index> places = model_.coefficients_of(model_.specification().random[term]);
    const Index q = std::ssize(places);
    std::map<Index, Index> first_column;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Index group = model_.group_of(term, cell_of_[rows[i]]);
      const auto [found, is_new] = first_column.try_emplace(group, effects.cols());
      if (is_new) {
        effects.conservativeResize(Eigen::NoChange, effects.cols() + q);
        effects.rightCols(q).setZero();
      }
      effects.row(static_cast<Index>(i)).segment(found->second, q) = jacobian_(rows[i], places);
    }
  }

  const NonlinearModel& model_;
  MatrixXd jacobian_;  ///< with columns of length 1
  Eigen::VectorX<Index> cell_of_;
};

}  // namespace

Degeneracy degeneracy(const NonlinearModel& model,
                      const CoefficientFrame& frame,
                      const MixedEffectsFit& fit) {
  if (fit.residual_sd.size() == 0 || !fit.residual_sd.allFinite()) return {};
  const double spread = spread_of(model.response());
  Degeneracy exact{.reason = exactness(model, fit, spread)};
  exact.is_exact = exact.reason.has_value();
  const ModelSpecification& specification = model.specification();
  if (exact.is_exact || specification.random.empty()) return exact;
  const Curves curves(model, fit.estimate);
  const Index p = model.column_count();
  for (std::size_t t = fit.random.size(); t-- > 0;) {
    const EffectLevel level{.names = fit.random[t].names,
                            .covariance = fit.random[t].covariance,
                            .frame = frame.effects[t],
                            .places = model.coefficients_of(specification.random[t])};
    Degeneracy result = unbounded_effect(level, curves, p, spread);
    if (!result.reason) result = impossible_error(model, fit, level, model.group_count(t));
    if (result.reason) return result;
  }
  return {};
}

std::vector<std::string> strata_without_freedom(const NonlinearModel& model,
                                                const MixedEffectsFit& fit,
                                                PassingEffects effects) {
  std::vector<std::string> result;
  if (!fit.estimate.allFinite()) return result;
  std::optional<StratumRanks> ranks;
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    if (factor.ratio.size() == 0 || factor.factor.stratum.empty()) continue;
    if (!ranks) ranks.emplace(model, model.curve_at(group_coefficients(model, fit)).jacobian);
    if (!ranks->are_known()) return result;
    const NonlinearModel::Strata& strata = model.strata(factor.factor.stratum);
    std::vector<std::vector<Index>> rows(strata.labels.size());
    for (std::size_t i = 0; i < strata.of_rows.size(); ++i) {
      rows[static_cast<std::size_t>(strata.of_rows[i])].push_back(static_cast<Index>(i));
    }
    for (std::size_t s = 0; s < rows.size(); ++s) {
      if (ranks->can_vanish(rows[s], effects)) result.push_back(strata.labels[s]);
    }
  }
  return result;
}

bool fits_exactly(const NonlinearModel& model, const MixedEffectsFit& fit) {
  const bool is_known = fit.residual_sd.size() > 0 && fit.residual_sd.allFinite();
  return is_known && exactness(model, fit, spread_of(model.response())).has_value();
}

bool has_no_maximum(const NonlinearModel& model, const MixedEffectsFit& fit) {
  return degeneracy(model, frame_at(model, fit.estimate), fit).reason.has_value();
}

}  // namespace silvafit::fit
