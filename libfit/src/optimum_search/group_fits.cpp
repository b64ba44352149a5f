// SPDX-License-Identifier: MIT
#include "optimum_search/group_fits.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "least_squares/exchanged_minima.hpp"
#include "least_squares/levenberg_marquardt.hpp"
#include "least_squares/periodic_coefficients.hpp"
#include "least_squares/start_search.hpp"
#include "least_squares/variable_projection.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

constexpr std::size_t kMostGroups = 40;
constexpr double kClearlyLower = 0.99;
// Searches in single groups, which are many, have half of the usual effort.
constexpr std::size_t kBrief = 2;

/// (p) the median of each coefficient; for an even number of fits the upper of the two middle
/// values, so that it is the value of a fit.
/// \param values  (p) lists, of at least one value each
VectorXd medians(std::vector<std::vector<double>> values) {
  VectorXd result(std::ssize(values));
  for (std::size_t j = 0; j < values.size(); ++j) {
    const auto middle = values[j].begin() + std::ssize(values[j]) / 2;
    std::ranges::nth_element(values[j], middle);
    result[static_cast<Index>(j)] = *middle;
  }
  return result;
}

bool is_clearly_lower(const GroupFits& found, const std::optional<GroupFits>& usual) {
  return !usual || found.fitted > usual->fitted ||
         found.sum_of_squares < kClearlyLower * usual->sum_of_squares;
}

Descent descended(const NonlinearModel& group, const VectorXd& start) {
  ProjectedModel projected(group);
  return descend(
      projected, projected.nonlinear_part(start), {.maximum_iterations = 50, .tolerance = 1e-9});
}

/// Groups with some observations more than parameters, thinned to a bounded number.
std::vector<Index> groups_to_fit(const NonlinearModel& model, Index parameters, std::size_t most) {
  std::vector<Index> groups;
  for (Index g = 0; g < model.group_count(); ++g) {
    if (model.group_begin(g + 1) - model.group_begin(g) > parameters) groups.push_back(g);
  }
  if (groups.size() <= most) return groups;
  std::vector<Index> chosen;
  for (std::size_t k = 0; k < most; ++k) chosen.push_back(groups[k * groups.size() / most]);
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
    const double* const multiplier = model.design().multiplier(j);
    const double mean = multiplier == nullptr
                            ? 1.0
                            : Eigen::Map<const VectorXd>(multiplier, model.observations()).mean();
    result[model.design().parameter_of(j)] += coefficients[j] * mean;
  }
  return result;
}

/// Shifts angles by whole periods, so that their sum of squares around their mean is the least one.
/// The circle is cut between two of them.
/// \param angles  NaN are left
void gather_angles(double period, Eigen::Ref<VectorXd> angles) {
  std::vector<Index> order;
  for (Index g = 0; g < angles.size(); ++g) {
    if (std::isnan(angles[g])) continue;
    angles[g] -= period * std::floor(angles[g] / period);
    order.push_back(g);
  }
  std::ranges::sort(order, {}, [&](Index g) { return angles[g]; });
  const auto count = static_cast<double>(order.size());
  double sum = angles(order).sum();
  double squares = angles(order).squaredNorm();
  double least = kInfinity;
  std::size_t cut = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double around_mean = squares - sum * sum / count;
    if (around_mean < least) {
      least = around_mean;
      cut = k;
    }
    const double angle = angles[order[k]];
    sum += period;
    squares += period * (period + 2.0 * angle);
  }
  for (std::size_t k = 0; k < cut; ++k) angles[order[k]] += period;
}

/// Own parameters of groups, with the sum of squares of their fits.
class OwnParameters {
 public:
  OwnParameters(Index parameters, Index groups)
      : own_(MatrixXd::Constant(parameters, groups, kNaN)),
        periods_(MatrixXd::Constant(parameters, groups, kNaN)) {}

  /// \param freedom  observations of the group less fitted parameters
  void add(Index group, const VectorXd& parameters, double sum_of_squares, Index freedom) {
    own_.col(group) = parameters;
    ++fitted_;
    sum_of_squares_ += sum_of_squares;
    freedom_ += freedom;
  }

  /// \param phases  of the fit of the group
  void set_periods(Index group, const std::vector<PhaseCoefficient>& phases) {
    for (const PhaseCoefficient& phase : phases) periods_(phase.coefficient, group) = phase.period;
  }

  /// None if too few groups have a fit.
  std::optional<GroupFits> fits() && {
    constexpr std::size_t kFewest = 3;
    if (own_.rows() == 0 || fitted_ < kFewest) return std::nullopt;
    gather_phases();
    std::vector<std::vector<double>> values(static_cast<std::size_t>(own_.rows()));
    for (Index k = 0; k < own_.rows(); ++k) {
      std::ranges::copy_if(own_.row(k),
                           std::back_inserter(values[static_cast<std::size_t>(k)]),
                           [](double value) { return !std::isnan(value); });
    }
    return GroupFits{.own = std::move(own_),
                     .medians = medians(std::move(values)),
                     .fitted = fitted_,
                     .sum_of_squares = sum_of_squares_,
                     .residual_sd = std::sqrt(sum_of_squares_ / static_cast<double>(freedom_))};
  }

 private:
  /// Phases are angles, of which a median means nothing.
  void gather_phases() {
    for (Index k = 0; k < own_.rows(); ++k) {
      double least = kInfinity;
      double most = 0.0;
      bool is_phase = true;
      for (Index g = 0; g < own_.cols(); ++g) {
        if (std::isnan(own_(k, g))) continue;
        is_phase = is_phase && std::isfinite(periods_(k, g));
        least = std::min(least, periods_(k, g));
        most = std::max(most, periods_(k, g));
      }
      constexpr double kSame = 1e-9;
      if (!is_phase || most - least > kSame * most) continue;
      VectorXd angles = own_.row(k).transpose();
      gather_angles(most, angles);
      own_.row(k) = angles.transpose();
    }
  }

  MatrixXd own_;
  MatrixXd periods_;  ///< (K x G) of phases; NaN for other parameters
  std::size_t fitted_ = 0;
  double sum_of_squares_ = 0.0;
  Index freedom_ = 0;
};

/// The observations of the groups that are fitted alone.
class SingleGroups {
 public:
  SingleGroups(const NonlinearModel& model, const NonlinearModel& constants)
      : group_count_(model.group_count()), count_(constants.coefficient_count()) {
    groups_ = groups_to_fit(model, count_, kMostGroups);
    for (const Index group : groups_) parts_.push_back(constants.subset(rows_of(model, group)));
  }

  /// Fits that begin at the same parameters; none if too few groups have one.
  std::optional<GroupFits> from(const VectorXd& start) const {
    return from_each(start.replicate(1, group_count_));
  }

  /// The same from own parameters of each group; NaN where there are none.
  std::optional<GroupFits> from_each(const MatrixXd& starts) const {
    OwnParameters own(count_, group_count_);
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const VectorXd start = starts.col(groups_[k]);
      if (!start.allFinite()) continue;
      const Descent descent = descended(parts_[k], start);
      if (descent.coefficients.size() == 0 || !descent.coefficients.allFinite()) continue;
      const Index freedom = parts_[k].observations() - count_;
      own.add(groups_[k],
              with_signs_of(parts_[k], descent.coefficients, start),
              descent.sum_of_squares,
              freedom);
      own.set_periods(groups_[k], phase_coefficients(parts_[k], descent.coefficients));
    }
    return std::move(own).fits();
  }

  /// The minimum of a group.
  struct Minimum {
    VectorXd parameters{};
    bool is_lower = false;  ///< clearly than the one near a start
  };

  /// The lowest minima of the largest groups but the first ones.
  std::vector<Minimum> minima_of_largest(const VectorXd& start,
                                         std::size_t first,
                                         std::size_t count) const {
    std::vector<Minimum> result;
    const std::vector<const NonlinearModel*> groups = by_size();
    for (std::size_t k = first; k < std::min(first + count, groups.size()); ++k) {
      const NonlinearModel& group = *groups[k];
      if (ProjectedModel(group).size() < 2) break;
      const double near = descended(group, start).sum_of_squares;
      for (const VectorXd& found : search_starts(group, {.count = 1, .divisor = kBrief})) {
        const bool is_lower = descended(group, found).sum_of_squares < kClearlyLower * near;
        result.push_back(
            {.parameters = with_nearest_phases(group, found, start), .is_lower = is_lower});
      }
    }
    return result;
  }

 private:
  /// Of equally large groups the first ones are those with the largest responses, so that the order
  /// of the rows does not matter.
  std::vector<const NonlinearModel*> by_size() const {
    std::vector<const NonlinearModel*> result;
    for (const NonlinearModel& group : parts_) result.push_back(&group);
    std::ranges::stable_sort(result, std::ranges::greater(), [](const NonlinearModel* group) {
      return std::pair(group->observations(), group->response().sum());
    });
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

/// Numbers of the parameters with random effects, but not of those that have no fixed effect.
std::vector<Index> varying(const NonlinearModel& model) {
  std::vector<Index> result;
  for (const RandomEffects& term : model.specification().random) {
    for (const Index place : model.coefficients_of(term)) {
      if (place < model.coefficient_count()) result.push_back(model.design().parameter_of(place));
    }
  }
  return result;
}

/// Fits of the parameters with random effects to each group, at the lowest minimum, with the others
/// held. Groups with fewer observations than parameters have a fit, too, and their own places of
/// peaks and steps are found wherever these are.
/// \param most  number of groups, at most
std::optional<GroupFits> fit_varying(const NonlinearModel& model,
                                     const NonlinearModel& constants,
                                     const VectorXd& parameters,
                                     std::size_t most) {
  const std::vector<Index> free = varying(model);
  std::map<std::string, double> held;
  for (Index k = 0; k < parameters.size(); ++k) {
    if (std::ranges::find(free, k) != free.end()) continue;
    held[constants.coefficient_names()[static_cast<std::size_t>(k)]] = parameters[k];
  }
  if (held.empty() || held.size() == static_cast<std::size_t>(parameters.size())) return {};
  const NonlinearModel of_groups = constants.with_held(held);
  const Index count = of_groups.coefficient_count();
  std::vector<Index> places;
  for (const std::string& name : of_groups.coefficient_names()) {
    places.push_back(constants.coefficient_index(name));
  }
  OwnParameters own(parameters.size(), model.group_count());
  for (const Index group : groups_to_fit(model, count, most)) {
    const NonlinearModel part = of_groups.subset(rows_of(model, group));
    for (const VectorXd& start : search_starts(part, {.count = 1, .divisor = kBrief})) {
      const Descent descent = descended(part, start);
      if (descent.coefficients.size() == 0 || !descent.coefficients.allFinite()) continue;
      VectorXd found = parameters;
      found(places) = with_nearest_phases(part, descent.coefficients, parameters(places));
      own.add(group, found, descent.sum_of_squares, part.observations() - count);
      for (PhaseCoefficient phase : phase_coefficients(part, descent.coefficients)) {
        phase.coefficient = places[static_cast<std::size_t>(phase.coefficient)];
        own.set_periods(group, {phase});
      }
    }
  }
  return std::move(own).fits();
}

/// The best of these fits from several parameters, which are compared in a few groups.
std::optional<GroupFits> best_varying(const NonlinearModel& model,
                                      const NonlinearModel& constants,
                                      const std::vector<VectorXd>& parameters) {
  constexpr std::size_t kFewGroups = 20;
  std::optional<GroupFits> best;
  const VectorXd* best_parameters = nullptr;
  for (const VectorXd& each : parameters) {
    auto found = fit_varying(model, constants, each, kFewGroups);
    const bool is_better =
        found && (!best || found->fitted > best->fitted ||
                  (found->fitted == best->fitted && found->sum_of_squares < best->sum_of_squares));
    if (!is_better) continue;
    best = std::move(found);
    best_parameters = &each;
  }
  if (!best) return std::nullopt;
  return fit_varying(model, constants, *best_parameters, kMostGroups);
}

/// Whether a parameter with random effects is nonlinear, such as the place of a peak. If groups
/// differ by more than a peak is wide, their mean has no peak.
bool varies_nonlinearly(const NonlinearModel& model, const NonlinearModel& constants) {
  const std::vector<Index> nonlinear = split_coefficients(constants).nonlinear;
  return std::ranges::any_of(varying(model), [&](Index parameter) {
    return std::ranges::find(nonlinear, parameter) != nonlinear.end();
  });
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
  constexpr std::size_t kGroups = 3;
  std::vector<SingleGroups::Minimum> minima = groups.minima_of_largest(start, 0, kGroups);
  for (const SingleGroups::Minimum& minimum : minima) {
    if (!minimum.is_lower) continue;
    std::optional<GroupFits> found = groups.from(minimum.parameters);
    if (!found) continue;
    if (is_clearly_lower(*found, usual)) result.push_back(*std::move(found));
  }
  const std::size_t count = result.size();
  for (std::size_t k = 0; k < count; ++k) {
    const GroupFits before = result[k];
    for (const Exchange& exchange : exchanges(constants, before.medians, varying(model))) {
      auto found = groups.from_each(exchanged(exchange, before));
      if (found) result.push_back(*std::move(found));
    }
  }
  const bool is_any_lower = std::ranges::any_of(minima, &SingleGroups::Minimum::is_lower);
  if (!is_any_lower || !varies_nonlinearly(model, constants)) return result;
  std::ranges::move(groups.minima_of_largest(start, kGroups, kGroups), std::back_inserter(minima));
  std::vector<VectorXd> typical{start};
  if (usual) typical.push_back(usual->medians);
  for (SingleGroups::Minimum& minimum : minima) typical.push_back(std::move(minimum.parameters));
  if (auto found = best_varying(model, constants, typical)) result.push_back(*std::move(found));
  return result;
}

std::optional<MixedEffectsFit> start_with_effects(const NonlinearModel& model,
                                                  const VectorXd& estimate,
                                                  const GroupFits& groups) {
  if (model.specification().random.size() != 1 || !(groups.residual_sd > 0.0)) return std::nullopt;
  const std::vector<Index> places = model.coefficients_of(model.specification().random.front());
  const auto count = static_cast<Index>(places.size());
  MixedEffectsFit result;
  result.estimate = estimate;
  result.random.resize(1);
  EstimatedEffects& random = result.random.front();
  random.effects = MatrixXd::Zero(count, model.group_count());
  for (Index k = 0; k < count; ++k) {
    const Index place = places[static_cast<std::size_t>(k)];
    // The effects of a covariate's coefficient, or without a fixed one, are not known from a single
    // group.
    if (model.design().multiplier(place) != nullptr) return std::nullopt;
    const Index parameter = model.design().parameter_of(place);
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
