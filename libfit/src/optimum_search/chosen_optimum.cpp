// SPDX-License-Identifier: MIT
#include "optimum_search/chosen_optimum.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "least_squares/exchanged_minima.hpp"
#include "lindstrom_bates/lindstrom_bates_search.hpp"
#include "marginal_likelihood/marginal_fit.hpp"
#include "optimization/tolerances.hpp"
#include "optimum_search/exchanged_fits.hpp"

namespace silvafit::fit {
namespace {

/// By name; `otherwise` for a coefficient without an entry.
template <typename Value>
Value value_of(const std::map<std::string, Value>& values,
               const std::string& name,
               Value otherwise) {
  const auto found = values.find(name);
  return found == values.end() ? otherwise : found->second;
}

/// Sum of the differences from the start values, relative to the sizes of both.
double distance(const std::vector<std::string>& names,
                const VectorXd& estimate,
                const std::map<std::string, double>& start) {
  double result = 0.0;
  for (std::size_t j = 0; j < names.size(); ++j) {
    const double value = estimate[static_cast<Index>(j)];
    const double from = value_of(start, names[j], value);
    if (value != from) result += std::abs(value - from) / (std::abs(value) + std::abs(from));
  }
  return result;
}

/// The estimates of a fit for the coefficients with start values.
std::map<std::string, double> of_start(const std::vector<std::string>& names,
                                       const Candidate& candidate,
                                       const FitModelOptions& wishes) {
  std::map<std::string, double> result;
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (wishes.start.contains(names[j])) {
      result[names[j]] = candidate.fit.estimate[static_cast<Index>(j)];
    }
  }
  return result;
}

}  // namespace

bool is_inside(const std::vector<std::string>& names,
               const VectorXd& estimate,
               const std::map<std::string, Bounds>& bounds) {
  for (std::size_t j = 0; j < names.size(); ++j) {
    const Bounds range = value_of(bounds, names[j], Bounds{});
    const double value = estimate[static_cast<Index>(j)];
    if (!(value >= range.low && value <= range.high)) return false;
  }
  return true;
}

const Candidate& chosen_optimum(const std::vector<std::string>& names,
                                const std::vector<Candidate>& candidates,
                                const Candidate& best,
                                const FitModelOptions& wishes) {
  std::vector<const Candidate*> possible;
  for (const Candidate& candidate : candidates) {
    if (!candidate.fit.convergence.converged()) continue;
    if (!is_inside(names, candidate.fit.estimate, wishes.bounds)) continue;
    possible.push_back(&candidate);
  }
  if (possible.empty()) return best;
  const Candidate* highest = std::ranges::find(possible, &best) != possible.end()
                                 ? &best
                                 : *std::ranges::max_element(possible, {}, &Candidate::rank);
  // Bounds fix the roles, too.
  if (wishes.start.empty() || !wishes.bounds.empty()) return *highest;
  const Candidate* chosen = highest;
  double nearest = distance(names, highest->fit.estimate, wishes.start);
  for (const Candidate* const candidate : possible) {
    if (!(candidate->rank > highest->rank - kVeryStrong)) continue;
    const double away = distance(names, candidate->fit.estimate, wishes.start);
    // Between optima that are nearer to each other than to the start, it is no choice of roles.
    const double apart =
        distance(names, candidate->fit.estimate, of_start(names, *highest, wishes));
    if (!(away < std::min(nearest, apart))) continue;
    if (!has_same_curves(candidate->fit, highest->fit, 1.0)) continue;
    nearest = away;
    chosen = candidate;
  }
  return *chosen;
}

MixedEffectsFit with_wished_roles(const NonlinearModel& model,
                                  const MixedEffectsFit& fit,
                                  Method method,
                                  const MixedEffectsOptions& options,
                                  const FitModelOptions& wishes) {
  const bool has_wishes = !wishes.start.empty() || !wishes.bounds.empty();
  if (!has_wishes || !fit.convergence.converged()) return fit;
  const std::vector<std::string>& names = model.coefficient_names();
  // Distances are sums in different orders.
  constexpr double kRounding = 1e-9;
  const auto is_nearer = [&](const VectorXd& a, const VectorXd& b) {
    const bool inside = is_inside(names, a, wishes.bounds);
    if (inside != is_inside(names, b, wishes.bounds)) return inside;
    return distance(names, a, wishes.start) < distance(names, b, wishes.start) - kRounding;
  };
  const auto refitted = [&](const MixedEffectsFit& start) {
    return is_marginal(method) ? marginal_from(model, start, method, options).fit
                               : lindstrom_bates_from(model, start, options).fit;
  };
  MixedEffectsFit result = fit;
  for (const VectorXd& point : points_of_same_mean(model, fit.estimate)) {
    if (!is_nearer(point, result.estimate)) continue;
    auto other = refitted(exchanged_fit(model, fit, point));
    if (other && other->convergence.converged() && is_same(*other, fit)) result = *std::move(other);
  }
  return result;
}

}  // namespace silvafit::fit
