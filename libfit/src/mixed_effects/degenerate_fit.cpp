// SPDX-License-Identifier: MIT
#include "mixed_effects/degenerate_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "model/symmetric_eigen.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Residuals that are smaller relative to the response's spread are rounding errors: measurements
// do not have so many digits.
constexpr double kRoundedResidual = 1e-6;
// The same for one observation per group, where random effects compete with the residual.
constexpr double kNothingLeft = 1e-2;
// Curves at larger distances, in spreads of the response, are degenerate.
constexpr double kBeyondMeasure = 1e6;
// Curves with smaller differences, in spreads of the response, are equal.
constexpr double kSame = 1e-6;

/// Standard deviation of the response, or its size if it is constant.
double spread_of(const VectorXd& response) {
  const auto n = static_cast<double>(response.size());
  const double spread = (response.array() - response.mean()).matrix().norm() / std::sqrt(n);
  return spread > 0.0 ? spread : std::abs(response.mean());
}

double typical_residual(const MixedEffectsFit& fit) {
  return fit.residual_sd.norm() / std::sqrt(static_cast<double>(fit.residual_sd.size()));
}

std::string exactness(const NonlinearModel& model, const MixedEffectsFit& fit, double spread) {
  const double residual = typical_residual(fit);
  const ModelSpecification& specification = model.specification();
  const bool is_single = !specification.random.empty() &&
                         model.group_count(model.term_count() - 1) == model.observations();
  if (is_single && residual < kNothingLeft * spread) {
    return fmt::format(
        "each group of {} has one observation, so its random effects fit it perfectly and the "
        "residual standard deviation goes to 0. Remove the random effects, or use groups with "
        "several observations.",
        specification.random.back().group);
  }
  if (!(residual < kRoundedResidual * spread)) return {};
  return fmt::format(
      "perfect fit: the model{} goes through all observations, so the residual standard deviation "
      "goes to 0 and the likelihood has no maximum. Check whether the response was computed from "
      "the covariates instead of measured.",
      !specification.random.empty() ? " with its random effects" : "");
}

/// The curves of the population and of groups with effects in one direction.
class Curves {
 public:
  Curves(const NonlinearModel& model, const VectorXd& estimate)
      : model_(model), estimate_(estimate), population_(at(VectorXd::Zero(estimate.size()))) {}

  VectorXd at(const VectorXd& shift) {
    VectorXd mean;
    model_.evaluate(estimate_ + shift, mean, nullptr, workspace_);
    return mean;
  }

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
  bool is_ordinary(const VectorXd& shift, double spread) {
    return is_near(at(shift), spread) && is_near(at(-shift), spread);
  }

  bool is_beyond_measure(const VectorXd& shift, double spread) {
    return std::ranges::any_of(std::vector{2.0, -2.0}, [&](double size) {
      return distance(at(size * shift), population_) > kBeyondMeasure * spread;
    });
  }

  /// Whether one and two standard deviations give the same curve on either side, and the sides
  /// differ.
  bool is_saturated(const VectorXd& shift, double spread) {
    const VectorXd above = at(shift);
    const VectorXd below = at(-shift);
    return distance(above, below) > 1e-3 * spread &&
           distance(at(2.0 * shift), above) < kSame * spread &&
           distance(at(-2.0 * shift), below) < kSame * spread;
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
  const VectorXd& estimate_;
  NonlinearModel::Workspace workspace_;
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
  constexpr double kShare = 0.5;
  std::vector<std::string> names;
  for (Index k = 0; k < size.size(); ++k) {
    if (size[k] < kShare * size.maxCoeff()) continue;
    names.push_back(fmt::format("sd({})", level.names[static_cast<std::size_t>(k)]));
  }
  return names;
}

Degeneracy unbounded(const std::vector<std::string>& names, const char* why) {
  Degeneracy result{.text = fmt::format("{} grows without bound: {}", fmt::join(names, ", "), why)};
  for (const std::string& name : names) {
    result.evidence.push_back({.kind = Evidence::Kind::kUnbounded, .term = name});
  }
  return result;
}

/// The principal component of the effects of a grouping along which the curve degenerates, if any.
Degeneracy unbounded_effect(const EffectLevel& level, Curves& curves, Index p, double spread) {
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
      return unbounded(
          names_of(level, direction),
          "at two standard deviations from the center, the curve is more than a million times the "
          "spread of the response away. The data do not support this random effect; remove it, or "
          "choose another variance function.");
    }
    if (curves.is_saturated(shift, spread)) {
      return unbounded(
          names_of(level, direction),
          "at one standard deviation from the center, the curve no longer depends on the random "
          "effect. Remove the random effect.");
    }
  }
  return {};
}

/// A coefficient with a smaller standard error than its random effect allows, if any. The standard
/// error of the mean of G groups with standard deviation s is at least s/sqrt(G); the inverse of a
/// nearly singular information matrix may have smaller ones.
Degeneracy impossible_error(const NonlinearModel& model,
                            const MixedEffectsFit& fit,
                            const EffectLevel& level,
                            Index groups) {
  constexpr double kImpossible = 0.1;
  // Without a maximum, the curvature is not an information matrix.
  if (fit.covariance.size() == 0 || !fit.convergence.converged()) return {};
  for (std::size_t k = 0; k < level.places.size(); ++k) {
    const Index j = level.places[k];
    const auto at = static_cast<Index>(k);
    const double least =
        std::sqrt(level.covariance(at, at) / static_cast<double>(std::max<Index>(1, groups)));
    const double error = std::sqrt(fit.covariance(j, j));
    if (model.design().multiplier(j) != nullptr || !(error < kImpossible * least)) continue;
    return {
        .status = ConvergenceStatus::kNotIdentifiable,
        .evidence = {{.kind = Evidence::Kind::kHardlyIdentifiable,
                      .term = level.names[k],
                      .value = error}},
        .text = fmt::format("the information matrix is nearly singular: {} groups whose {} have a "
                            "standard deviation of {:.3g} cannot give their mean a standard error "
                            "of {:.2g}. The coefficients are hardly identifiable; fix or remove "
                            "one of them.",
                            groups,
                            level.names[k],
                            std::sqrt(level.covariance(at, at)),
                            error)};
  }
  return {};
}

}  // namespace

Degeneracy degeneracy(const NonlinearModel& model,
                      const CoefficientFrame& frame,
                      const MixedEffectsFit& fit) {
  if (fit.residual_sd.size() == 0 || !fit.residual_sd.allFinite()) return {};
  const double spread = spread_of(model.response());
  Degeneracy exact{.text = exactness(model, fit, spread)};
  exact.is_exact = !exact.text.empty();
  const ModelSpecification& specification = model.specification();
  if (exact.is_exact || specification.random.empty()) return exact;
  Curves curves(model, fit.estimate);
  const Index p = fit.estimate.size();
  for (std::size_t t = fit.random.size(); t-- > 0;) {
    const EffectLevel level{.names = fit.random[t].names,
                            .covariance = fit.random[t].covariance,
                            .frame = frame.effects[t],
                            .places = model.coefficients_of(specification.random[t])};
    Degeneracy result = unbounded_effect(level, curves, p, spread);
    if (result.text.empty()) result = impossible_error(model, fit, level, model.group_count(t));
    if (!result.text.empty()) return result;
  }
  return {};
}

bool fits_exactly(const NonlinearModel& model, const MixedEffectsFit& fit) {
  const bool is_known = fit.residual_sd.size() > 0 && fit.residual_sd.allFinite();
  return is_known && !exactness(model, fit, spread_of(model.response())).empty();
}

bool has_no_maximum(const NonlinearModel& model, const MixedEffectsFit& fit) {
  return !degeneracy(model, frame_at(model, fit.estimate), fit).text.empty();
}

}  // namespace silvafit::fit
