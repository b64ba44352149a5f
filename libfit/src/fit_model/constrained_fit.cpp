// SPDX-License-Identifier: MIT
#include "fit_model/constrained_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "fit_model/bound_slopes.hpp"
#include "fit_model/bounded_search.hpp"
#include "model/held_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;
using Values = std::map<std::string, double>;

/// Values of all coefficients: of the held ones their values, of the others those given.
VectorXd with_held_values(const std::vector<std::string>& names,
                          const Values& held,
                          const VectorXd& free) {
  VectorXd all(static_cast<Index>(names.size()));
  Index next = 0;
  for (Index j = 0; j < all.size(); ++j) {
    const auto found = held.find(names[static_cast<std::size_t>(j)]);
    all[j] = found == held.end() ? free[next++] : found->second;
  }
  return all;
}

/// The result of the model with held coefficients, described as that of the whole model.
FitResult expanded(FitResult result, const ModelSpecification& whole, const Values& held) {
  FittedModel& fit = result.fit;
  const std::vector<std::string> names = whole.coefficient_names();
  const auto p = static_cast<Index>(names.size());
  MatrixXd covariance = MatrixXd::Constant(p, p, kNaN);
  std::vector<Index> places;
  for (Index j = 0; j < p; ++j) {
    if (!held.contains(names[static_cast<std::size_t>(j)])) places.push_back(j);
  }
  covariance(places, places) = fit.covariance;
  VectorXd freedom = VectorXd::Constant(p, kNaN);
  Index next = 0;
  for (const Index j : places) freedom[j] = fit.degrees_of_freedom[next++];
  fit.degrees_of_freedom = std::move(freedom);
  fit.estimate = with_held_values(names, held, fit.estimate);
  for (LocalOptimum& optimum : fit.optima) {
    optimum.estimate = with_held_values(names, held, optimum.estimate);
  }
  fit.covariance = std::move(covariance);
  fit.coefficient_names = names;
  fit.specification = whole;
  return result;
}

/// The result if the formula has no value with these coefficients held.
FitResult impossible(const ModelSpecification& whole, const Values& held, const Error& reason) {
  FitResult result{.fit = FittedModel(whole)};
  FittedModel& fit = result.fit;
  fit.set_missing(whole);
  fit.estimate = with_held_values(fit.coefficient_names, held, fit.estimate);
  std::vector<std::string> values;
  for (const auto& [name, value] : held) values.push_back(name + " = " + data::shortest(value));
  fit.convergence.conclude(
      ConvergenceStatus::kNoStartValues,
      {.kind = Finding::Kind::kHeldImpossible,
       .names = {fmt::format("{}", fmt::join(values, " and ")), std::string(reason.what())}});
  return result;
}

void check_bounds(const ModelSpecification& specification, const FitModelOptions& options) {
  for (const auto& [name, bounds] : options.bounds) {
    check_known(specification, name);
    if (!(bounds.low < bounds.high)) {
      throw UsageError(fmt::format("the lower bound of {} must be below its upper bound", name));
    }
    if (options.fixed.contains(name)) {
      throw UsageError(fmt::format("{} is both fixed and bounded; use one of the two", name));
    }
  }
}

}  // namespace

HeldFit held_fit_of(const ModelSpecification& specification,
                    const Values& fixed,
                    const FreeFit& fit) {
  return [&specification, &fixed, &fit](const Values& also_held, const FittedModel* nearby) {
    Values held = fixed;
    held.insert(also_held.begin(), also_held.end());
    try {
      return expanded(fit(with_constants(specification, held), nearby), specification, held);
    } catch (const DomainError& error) {
      // A value may be so far away that the formula has no value there.
      if (also_held.empty()) throw;
      return impossible(specification, held, error);
    }
  };
}

FitResult fit_constrained(const ModelSpecification& specification,
                          const data::Table& table,
                          const FitModelOptions& options,
                          const FreeFit& fit,
                          const InsideFit& inside) {
  check_bounds(specification, options);
  if (options.bounds.empty()) {
    return expanded(
        fit(with_held(specification, options.fixed), nullptr), specification, options.fixed);
  }
  const HeldFit fit_held = held_fit_of(specification, options.fixed, fit);
  const SlopesOf slopes_of = [&](const FittedModel& found, const Values& at_bound) {
    return at_held(found, table, options.fixed, at_bound);
  };
  const InsideFit fit_inside = [&](const FittedModel& found, const HeldValues& at_bounds) {
    Values held = options.fixed;
    held.insert(at_bounds.begin(), at_bounds.end());
    std::optional<FitResult> result = inside(found, held);
    if (result) result = expanded(*std::move(result), specification, held);
    return result;
  };
  return BoundedSearch(options.bounds, fit_held, slopes_of, fit_inside).run();
}

}  // namespace silvafit::fit
