// SPDX-License-Identifier: MIT
#include "optimum_search/starting_points.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "least_squares/exchanged_minima.hpp"
#include "least_squares/start_search.hpp"
#include "optimum_search/group_fits.hpp"
#include "optimum_search/search_evidence.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/data/equation.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

/// Names of the model's parameters.
std::vector<std::string> parameter_names(const NonlinearModel& model) {
  std::vector<std::string> names;
  for (const ParameterModel& parameter : model.specification().parameters) {
    names.push_back(parameter.name);
  }
  return names;
}

/// (N) an expression of the model's columns.
VectorXd column_values(const NonlinearModel& model, const Expression& expression) {
  const MatrixXd& columns = model.variable_values();
  VectorXd result(model.observations());
  std::vector<double> values(model.variables().size());
  for (Index i = 0; i < result.size(); ++i) {
    for (Index k = 0; k < columns.cols(); ++k) {
      values[static_cast<std::size_t>(k)] = columns(i, k);
    }
    result[i] = expression.value(model.variables(), values);
  }
  return result;
}

/// Constants of the parameters by least squares of a transformed equation of the model; no value if
/// too few observations have a finite value, or without a fit.
std::optional<VectorXd> fit_equation(const NonlinearModel& model,
                                     const Expression& mean,
                                     const VectorXd& response) {
  std::vector<Index> finite;
  for (Index i = 0; i < response.size(); ++i) {
    if (std::isfinite(response[i])) finite.push_back(i);
  }
  const auto parameters = static_cast<Index>(model.specification().parameters.size());
  if (static_cast<Index>(finite.size()) <= parameters) return std::nullopt;
  const NonlinearModel part = model.subset(finite);
  try {
    const LeastSquaresFit fit =
        fit_least_squares(part.with_equation(mean, VectorXd(response(finite))));
    return fit.estimate.allFinite() ? std::optional(fit.estimate) : std::nullopt;
  } catch (const DomainError&) {
    // The transformed equation may be undefined where the formula is not: a logarithm of zero.
    return std::nullopt;
  }
}

/// Collects distinct points.
class Collection {
 public:
  explicit Collection(const NonlinearModel& model) : model_(model) {}

  void add(VectorXd coefficients,
           std::string origin,
           std::optional<MixedEffectsFit> with_effects = std::nullopt) {
    if (coefficients.size() != model_.coefficient_count() || !coefficients.allFinite()) return;
    const bool is_known = std::ranges::any_of(points_, [&](const StartingPoint& other) {
      constexpr double kSamePlace = 1e-4;
      const Eigen::ArrayXd sizes = coefficients.array().abs().max(other.coefficients.array().abs());
      return ((coefficients - other.coefficients).array().abs() <= kSamePlace * sizes).all();
    });
    if (is_known) return;
    points_.push_back({.coefficients = std::move(coefficients),
                       .origin = std::move(origin),
                       .with_effects = std::move(with_effects)});
  }

  void add_groups(const NonlinearModel& constants, const GroupFits& groups) {
    const VectorXd estimate = spread_constants(model_, constants, groups.medians);
    add(estimate, std::string(kGroupMedians), start_with_effects(model_, estimate, groups));
  }

  /// Exchanged terms of all points so far.
  void add_exchanged() {
    const std::vector<StartingPoint> points = points_;
    for (const StartingPoint& point : points) {
      for (VectorXd& other : exchanged_minima(model_, point.coefficients)) {
        add(std::move(other), point.origin + " with exchanged terms");
      }
    }
  }

  /// From a value of each parameter.
  void add_constants(const std::optional<VectorXd>& constants, std::string origin) {
    if (!constants) return;
    add(spread_constants(model_, model_.pooled(), *constants), std::move(origin));
  }

  const std::vector<StartingPoint>& points() const { return points_; }
  std::vector<StartingPoint> take() && { return std::move(points_); }

 private:
  const NonlinearModel& model_;
  std::vector<StartingPoint> points_;
};

/// The fits of the formula in its linear form, and of its logarithm.
void add_solved_equation(const NonlinearModel& model, Collection& collection) {
  constexpr Index kSample = 400;
  const ModelSpecification& specification = model.specification();
  const data::SolvedEquation equation =
      data::solve_for(specification.formula.right,
                      parameter_names(model),
                      Expression::variable(specification.formula.left));
  const NonlinearModel part = model.subset(even_sample(model.response(), kSample));
  const VectorXd value = column_values(part, equation.value);
  if (equation.value.text() != specification.formula.left) {
    collection.add_constants(fit_equation(part, equation.part, value), "solved formula");
  }
  if ((value.array() > 0.0).any()) {
    collection.add_constants(fit_equation(part, log(equation.part), value.array().log().matrix()),
                             "logarithm of the formula");
  }
}

/// Points around the existing ones, at distances of their differences, and at least half of their
/// size.
void add_spread(int count, Collection& collection) {
  if (collection.points().empty()) return;
  const std::vector<StartingPoint> centers = collection.points();
  const VectorXd& first = centers.front().coefficients;
  constexpr double kShare = 0.5;
  VectorXd spread = kShare * first.cwiseAbs();
  for (const StartingPoint& center : centers) {
    spread = spread.cwiseMax(kShare * (center.coefficients - first).cwiseAbs());
  }
  constexpr std::uint64_t kSeed = 1;
  for (int k = 0; k < count; ++k) {
    Random random(kSeed, static_cast<std::uint64_t>(k));
    VectorXd point = centers[static_cast<std::size_t>(k) % centers.size()].coefficients;
    for (Index j = 0; j < point.size(); ++j) point[j] += spread[j] * random.normal();
    collection.add(std::move(point), std::string(kSpreadStart));
  }
}

}  // namespace

std::vector<StartingPoint> starting_points(const NonlinearModel& model,
                                           const LeastSquaresFit& pooled,
                                           int spread) {
  Collection collection(model);
  collection.add(pooled.estimate, std::string(kPooledFit));
  for (const VectorXd& other : pooled.other_minima) {
    collection.add(other, std::string(kOtherMinimum));
  }
  if (!model.specification().random.empty()) {
    const NonlinearModel constants = model.pooled();
    for (const GroupFits& found : fit_single_groups(model, constants, pooled.estimate)) {
      collection.add_groups(constants, found);
    }
  }
  add_solved_equation(model, collection);
  if (!model.specification().random.empty()) collection.add_exchanged();
  add_spread(spread, collection);
  return std::move(collection).take();
}

}  // namespace silvafit::fit
