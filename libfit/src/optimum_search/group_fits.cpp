// SPDX-License-Identifier: MIT
#include "optimum_search/group_fits.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>

#include "least_squares/exchanged_minima.hpp"
#include "least_squares/levenberg_marquardt.hpp"
#include "least_squares/start_search.hpp"
#include "least_squares/variable_projection.hpp"
#include "mixed_effects/medians.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Groups with some observations more than parameters, thinned to a bounded number.
std::vector<Index> groups_to_fit(const NonlinearModel& model, Index parameters) {
  constexpr std::size_t kMostGroups = 40;
  std::vector<Index> groups;
  for (Index g = 0; g < model.group_count(); ++g) {
    if (model.group_begin(g + 1) - model.group_begin(g) > parameters) groups.push_back(g);
  }
  if (groups.size() <= kMostGroups) return groups;
  std::vector<Index> chosen;
  for (std::size_t k = 0; k < kMostGroups; ++k) {
    chosen.push_back(groups[k * groups.size() / kMostGroups]);
  }
  return chosen;
}

/// Observations of a group, thinned to the number that a curve needs.
std::vector<Index> rows_of(const NonlinearModel& model, Index group) {
  constexpr Index kMostRows = 200;
  const Index begin = model.group_begin(group);
  const Index count = model.group_begin(group + 1) - begin;
  const Index taken = std::min(count, kMostRows);
  std::vector<Index> rows;
  for (Index k = 0; k < taken; ++k) rows.push_back(begin + k * count / taken);
  return rows;
}

/// (K) typical values of the parameters at given coefficients: their means over the observations.
VectorXd mean_parameters(const NonlinearModel& model, const VectorXd& coefficients, Index count) {
  VectorXd result = VectorXd::Zero(count);
  for (Index j = 0; j < coefficients.size(); ++j) {
    result[model.parameter_of(j)] += coefficients[j] * model.multiplier(j).mean();
  }
  return result;
}

/// The observations of the groups that are fitted alone.
class SingleGroups {
 public:
  SingleGroups(const NonlinearModel& model, const NonlinearModel& constants)
      : group_count_(model.group_count()), count_(constants.coefficient_count()) {
    groups_ = groups_to_fit(model, count_);
    for (const Index group : groups_) parts_.push_back(constants.subset(rows_of(model, group)));
  }

  /// Fits that begin at the same parameters; none if too few groups have one.
  std::optional<GroupFits> from(const VectorXd& start) const {
    return from_each(start.replicate(1, group_count_));
  }

  /// The same from own parameters of each group; NaN where there are none.
  std::optional<GroupFits> from_each(const MatrixXd& starts) const {
    constexpr std::size_t kFewest = 3;
    GroupFits result;
    result.own = MatrixXd::Constant(count_, group_count_, kNaN);
    std::vector<std::vector<double>> values(static_cast<std::size_t>(count_));
    Index freedom = 0;
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const VectorXd start = starts.col(groups_[k]);
      if (!start.allFinite()) continue;
      const Descent descent = descended(parts_[k], start);
      if (descent.coefficients.size() == 0 || !descent.coefficients.allFinite()) continue;
      result.own.col(groups_[k]) = descent.coefficients;
      result.sum_of_squares += descent.sum_of_squares;
      freedom += parts_[k].observations() - count_;
      for (Index j = 0; j < count_; ++j) {
        values[static_cast<std::size_t>(j)].push_back(descent.coefficients[j]);
      }
    }
    if (count_ == 0 || values.front().size() < kFewest) return std::nullopt;
    result.fitted = values.front().size();
    result.medians = medians(std::move(values));
    result.residual_sd = std::sqrt(result.sum_of_squares / static_cast<double>(freedom));
    return result;
  }

  /// Minima of the largest groups that are clearly lower than those from a start.
  std::vector<VectorXd> lower_than_from(const VectorXd& start) const {
    std::vector<VectorXd> result;
    for (const NonlinearModel* const group : largest()) {
      if (ProjectedModel(*group).size() < 2) break;
      const double near = descended(*group, start).sum_of_squares;
      for (const VectorXd& found : search_starts(*group, {.count = 1})) {
        if (descended(*group, found).sum_of_squares < kClearlyLower * near) result.push_back(found);
      }
    }
    return result;
  }

  static constexpr double kClearlyLower = 0.99;

 private:
  static Descent descended(const NonlinearModel& group, const VectorXd& start) {
    ProjectedModel projected(group);
    return descend(
        projected, projected.nonlinear_part(start), {.maximum_iterations = 50, .tolerance = 1e-9});
  }

  std::vector<const NonlinearModel*> largest() const {
    constexpr std::size_t kMost = 3;
    std::vector<const NonlinearModel*> result;
    for (const NonlinearModel& group : parts_) result.push_back(&group);
    std::ranges::stable_sort(result, std::ranges::greater(), &NonlinearModel::observations);
    result.resize(std::min(kMost, result.size()));
    return result;
  }

  Index group_count_;
  Index count_;
  std::vector<Index> groups_;
  std::vector<NonlinearModel> parts_;
};

/// (G) deviations of a parameter from its median. Those of failed fits are limited to a multiple of
/// their median size; they are 0 for groups without a fit.
VectorXd deviations_of(const VectorXd& own, double median) {
  constexpr double kMost = 5.0;
  VectorXd result = (own.array() - median).matrix();
  std::vector<double> sizes;
  for (const double value : result) {
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  }
  const double limit = kMost * medians({std::move(sizes)})[0];
  for (double& value : result) {
    value = std::isfinite(value) ? std::clamp(value, -limit, limit) : 0.0;
  }
  return result;
}

/// (K x G) the groups' own parameters after an exchange. A phase is shifted by periods of its own
/// group, so that all groups start from the same phase.
MatrixXd exchanged(const Exchange& exchange, const GroupFits& groups) {
  const VectorXd medians = exchange.of(groups.medians);
  MatrixXd result = groups.own;
  for (Index g = 0; g < result.cols(); ++g) {
    const VectorXd own = exchange.of(groups.own.col(g));
    result.col(g) = exchange.is_shift() && own.allFinite() ? medians : own;
  }
  return result;
}

/// Numbers of the parameters with random effects.
std::vector<Index> varying(const NonlinearModel& model) {
  std::vector<Index> result;
  for (const RandomEffects& term : model.specification().random) {
    for (const Index place : model.coefficients_of(&term)) {
      result.push_back(model.parameter_of(place));
    }
  }
  return result;
}

}  // namespace

std::vector<GroupFits> fit_single_groups(const NonlinearModel& model,
                                         const NonlinearModel& constants,
                                         const VectorXd& pooled) {
  const SingleGroups groups(model, constants);
  const VectorXd start = mean_parameters(model, pooled, constants.coefficient_count());
  std::vector<GroupFits> result;
  const std::optional<GroupFits> usual = groups.from(start);
  if (usual) result.push_back(*usual);
  for (const VectorXd& other : groups.lower_than_from(start)) {
    std::optional<GroupFits> found = groups.from(other);
    if (!found) continue;
    const bool is_lower =
        !usual || found->fitted > usual->fitted ||
        found->sum_of_squares < SingleGroups::kClearlyLower * usual->sum_of_squares;
    if (is_lower) result.push_back(*std::move(found));
  }
  const std::size_t count = result.size();
  for (std::size_t k = 0; k < count; ++k) {
    const GroupFits before = result[k];
    for (const Exchange& exchange : exchanges(constants, before.medians, varying(model))) {
      auto found = groups.from_each(exchanged(exchange, before));
      if (found) result.push_back(*std::move(found));
    }
  }
  return result;
}

std::optional<MixedEffectsFit> start_with_effects(const NonlinearModel& model,
                                                  const VectorXd& estimate,
                                                  const GroupFits& groups) {
  if (model.specification().random.size() != 1 || !(groups.residual_sd > 0.0)) return std::nullopt;
  const std::vector<Index> places = model.coefficients_of(&model.specification().random.front());
  const auto count = static_cast<Index>(places.size());
  MixedEffectsFit result;
  result.estimate = estimate;
  result.random.resize(1);
  EstimatedEffects& random = result.random.front();
  random.effects = MatrixXd::Zero(count, model.group_count());
  for (Index k = 0; k < count; ++k) {
    const Index place = places[static_cast<std::size_t>(k)];
    // The effects of a covariate's coefficient are not known from a single group.
    if (model.multiplier_values(place) != nullptr) return std::nullopt;
    const Index parameter = model.parameter_of(place);
    random.effects.row(k) =
        deviations_of(groups.own.row(parameter), groups.medians[parameter]).transpose();
  }
  const VectorXd squares = random.effects.rowwise().squaredNorm();
  random.covariance = (squares / static_cast<double>(groups.fitted)).asDiagonal();
  const VarianceModel variance(model.specification().variance, VarianceData::of(model));
  result.variance = variance.estimate(variance.start());
  result.sigma = groups.residual_sd * variance.sigma_factor(variance.start());
  return result;
}

}  // namespace silvafit::fit
