// SPDX-License-Identifier: MIT
#include "silvafit/fit/derived_quantity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/near_names.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

std::vector<double> list_of(const VectorXd& values) { return {values.begin(), values.end()}; }

/// What fits report beside coefficients; those of random effects have parentheses.
constexpr std::array<std::string_view, 8> kOtherParameters{
    "sigma", "delta", "constant", "ratio", "phi", "rho", "range", "nugget"};

/// The place of the `=` behind a name; npos if there is none.
std::size_t equals_sign(std::string_view text) {
  const std::size_t at = text.find_first_of("=<>!`\"");
  const bool is_alone =
      at != std::string_view::npos && text[at] == '=' && !text.substr(at + 1).starts_with('=');
  return is_alone ? at : std::string_view::npos;
}

}  // namespace

double DerivedQuantity::at(const std::vector<std::string>& names, const VectorXd& estimate) const {
  return value.value(names, list_of(estimate));
}

VectorXd DerivedQuantity::gradient(const std::vector<std::string>& names,
                                   const VectorXd& estimate) const {
  VectorXd result = VectorXd::Zero(estimate.size());
  const std::vector<std::string> used = value.variables();
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (std::ranges::find(used, names[j]) == used.end()) continue;
    result[static_cast<Index>(j)] = value.derivative(names[j]).value(names, list_of(estimate));
  }
  return result;
}

data::Expression parse_derived_expression(std::string_view text,
                                          std::size_t begin,
                                          const std::vector<std::string>& coefficients) {
  data::Expression value = data::Expression::parse(text, begin, text.size());
  const std::vector<std::string> used = value.variables();
  for (const std::string& name : used) {
    if (std::ranges::find(coefficients, name) != coefficients.end()) continue;
    throw FormulaError(
        fmt::format(
            "'{}' is not a coefficient of the model{}", name, did_you_mean(name, coefficients)),
        text,
        text.find(name, begin) + 1);
  }
  if (used.empty()) throw FormulaError("does not depend on any coefficient", text, 1);
  return value;
}

DerivedQuantity parse_derived_quantity(std::string_view text,
                                       const std::vector<std::string>& coefficients) {
  const std::size_t equals = equals_sign(text);
  const bool has_name = equals != std::string_view::npos;
  DerivedQuantity result{
      .name = std::string(data::trimmed(has_name ? text.substr(0, equals) : text)),
      .value = parse_derived_expression(text, has_name ? equals + 1 : 0, coefficients)};
  if (result.name.empty()) throw FormulaError("the name before '=' is missing", text, 1);
  const bool is_taken = std::ranges::find(coefficients, result.name) != coefficients.end() ||
                        std::ranges::find(kOtherParameters, result.name) != kOtherParameters.end();
  if (is_taken) {
    throw FormulaError(
        fmt::format("'{}' is a parameter already; choose another name", result.name), text, 1);
  }
  return result;
}

namespace {

/// The degrees of freedom of coefficients, of which those that vary between groups are known from
/// these only; nlme gives an intercept those within groups.
VectorXd freedoms_of(const FittedModel& fit) {
  VectorXd freedoms = fit.degrees_of_freedom;
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    const double between = static_cast<double>(fit.random[k].labels.size()) - 1.0;
    for (const std::string& name : fit.specification.random[k].coefficients) {
      const auto place = std::ranges::find(fit.coefficient_names, name);
      const Index j = place - fit.coefficient_names.begin();
      if (j < freedoms.size()) freedoms[j] = std::fmin(freedoms[j], between);
    }
  }
  return freedoms;
}

}  // namespace

std::vector<DerivedValue> derived_values(const FittedModel& fit) {
  std::vector<DerivedValue> result;
  const std::vector<std::string>& names = fit.coefficient_names;
  const Eigen::MatrixXd covariance = fixed_covariance(fit);
  const VectorXd freedoms = freedoms_of(fit);
  for (const DerivedQuantity& quantity : fit.specification.derived) {
    DerivedValue& one =
        result.emplace_back(DerivedValue{quantity.at(names, fit.estimate), kNaN, kNaN});
    // A fit without estimates has no quantities; one with estimates has all.
    if (!std::isfinite(one.estimate) && fit.convergence.converged() && fit.estimate.allFinite()) {
      throw UsageError(fmt::format(
          "the derived quantity {} has no finite value at the estimates ({} = {}): its formula "
          "divides by 0 or is outside its domain there; change or remove it",
          quantity.name,
          quantity.value.text(),
          std::isnan(one.estimate) ? "undefined" : "infinite"));
    }
    const VectorXd gradient = quantity.gradient(names, fit.estimate);
    // Of a coefficient that is not identifiable the error is NaN, also times a gradient of 0.
    std::vector<Index> used;
    for (Index j = 0; j < gradient.size(); ++j) {
      if (gradient[j] == 0.0) continue;
      used.push_back(j);
      const double freedom = j < freedoms.size() ? freedoms[j] : kNaN;
      one.degrees_of_freedom = std::fmin(one.degrees_of_freedom, freedom);
    }
    const VectorXd slopes = gradient(used);
    const double variance = slopes.dot(covariance(used, used) * slopes);
    if (variance > 0.0) one.standard_error = std::sqrt(variance);
  }
  return result;
}

}  // namespace silvafit::fit
