// SPDX-License-Identifier: MIT
// The expected information on variances of random effects that are zero.
#include "silvafit/fit/covariance_of_variances.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "linearization.hpp"
#include "silvafit/base/error.hpp"
#include "variance_weights.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Effects = std::vector<std::string>;

bool contains(const Effects& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// The smaller model with room for the effects of the larger one.
ModelSpecification joined(const FittedModel& larger, const FittedModel& smaller) {
  const bool is_nested = larger.specification.outer_random || smaller.specification.outer_random;
  if (!larger.specification.random || is_nested) {
    throw UsageError("variances are compared where the larger model has one grouping");
  }
  if (larger.coefficient_names != smaller.coefficient_names) {
    throw UsageError("variances are compared in models with the same coefficients");
  }
  ModelSpecification specification = smaller.specification;
  specification.random = larger.specification.random;
  return specification;
}

/// Parameters of the covariance of observations: each is a symmetric pair of random columns, new
/// variances first, then the elements that the smaller model estimates.
std::vector<std::pair<Index, Index>> elements(const FittedModel& larger,
                                              const FittedModel& smaller,
                                              Index& new_variances) {
  const Effects& names = larger.random_names;
  std::vector<std::pair<Index, Index>> result;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!contains(smaller.random_names, names[i])) result.emplace_back(i, i);
  }
  new_variances = static_cast<Index>(result.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      if (!contains(smaller.random_names, names[i]) || !contains(smaller.random_names, names[j])) {
        continue;
      }
      const bool is_free =
          i == j || smaller.specification.random->covariance == Covariance::kGeneral;
      if (is_free) result.emplace_back(i, j);
    }
  }
  return result;
}

/// tr(P E_a Q E_b) / 2 for symmetric P and Q, with E of the element (i, j) symmetric.
double trace_of(const MatrixXd& p,
                const MatrixXd& q,
                const std::pair<Index, Index>& a,
                const std::pair<Index, Index>& b) {
  const auto at = [&](Index i, Index j, Index k, Index l) { return p(l, i) * q(j, k); };
  double sum = at(a.first, a.second, b.first, b.second);
  if (a.first != a.second) sum += at(a.second, a.first, b.first, b.second);
  if (b.first != b.second) sum += at(a.first, a.second, b.second, b.first);
  if (a.first != a.second && b.first != b.second) {
    sum += at(a.second, a.first, b.second, b.first);
  }
  return 0.5 * sum;
}

}  // namespace

MatrixXd covariance_of_variances(const FittedModel& larger,
                                 const FittedModel& smaller,
                                 const data::Table& table) {
  const NonlinearModel model(joined(larger, smaller), table);
  Index new_variances = 0;
  const auto parameters = elements(larger, smaller, new_variances);
  if (new_variances == 0) throw UsageError("the larger model has no more random effects");
  const VarianceModel variance(smaller.specification.variance, VarianceData::of(model));
  const VectorXd internal = variance.parameters(smaller.variance);
  const double sigma = smaller.sigma / variance.sigma_factor(internal);

  const auto q = static_cast<Index>(larger.random_names.size());
  const std::vector<Index> places = model.coefficients_of(model.specification().random);
  LinearizationPoint point{
      .coefficients = smaller.estimate,
      .effects = MatrixXd::Zero(model.coefficient_count(), model.group_count()),
      .variance = internal,
      .units = VectorXd::Ones(model.coefficient_count())};
  MatrixXd psi = MatrixXd::Zero(q, q);
  for (std::size_t i = 0; i < smaller.random_names.size(); ++i) {
    const auto from = static_cast<Index>(i);
    const auto to = std::ranges::find(larger.random_names, smaller.random_names[i]) -
                    larger.random_names.begin();
    point.effects.row(places[static_cast<std::size_t>(to)]) = smaller.random_effects.row(from);
    for (std::size_t j = 0; j < smaller.random_names.size(); ++j) {
      const auto other = std::ranges::find(larger.random_names, smaller.random_names[j]) -
                         larger.random_names.begin();
      psi(to, other) = smaller.random_covariance(from, static_cast<Index>(j));
    }
  }
  Linearization at;
  if (!Linearizer(model, variance).linearize(point, false, nullptr, at)) {
    throw UsageError("the model has no finite slopes at the estimates of the smaller fit");
  }

  const auto k = static_cast<Index>(parameters.size());
  MatrixXd information = MatrixXd::Zero(k + 1, k + 1);
  const double precision = 1.0 / (sigma * sigma);
  const MatrixXd relative = precision * psi;
  const Index width = at.model.moments.width();
  for (Index g = 0; g < model.group_count(); ++g) {
    const Eigen::Map<const MatrixXd> products(at.model.moments.term(g, 0), width, width);
    const MatrixXd m = products(places, places);
    // B = (D^-1 + M)^-1, also for a singular D.
    const MatrixXd b = (MatrixXd::Identity(q, q) + relative * m).partialPivLu().solve(relative);
    const MatrixXd rest = MatrixXd::Identity(q, q) - b * m;
    const MatrixXd p = precision * m * rest;  // Z'V^-1 Z
    const MatrixXd twice =
        precision * precision * rest.transpose() * m * rest;  // Z'V^-1 G^2 V^-1 Z
    for (Index i = 0; i < k; ++i) {
      for (Index j = 0; j < k; ++j) {
        information(i, j) += trace_of(
            p, p, parameters[static_cast<std::size_t>(i)], parameters[static_cast<std::size_t>(j)]);
      }
      const auto& [row, column] = parameters[static_cast<std::size_t>(i)];
      const double by_sigma = 0.5 * twice(row, column) * (row == column ? 1.0 : 2.0);
      information(i, k) += by_sigma;
      information(k, i) += by_sigma;
    }
    const MatrixXd hidden = b * m;
    const auto rows = static_cast<double>(model.group_begin(g + 1) - model.group_begin(g));
    information(k, k) +=
        0.5 * precision * precision * (rows - 2.0 * hidden.trace() + (hidden * hidden).trace());
  }
  // In units that make the diagonal one, so that the sizes of the parameters do not matter.
  const VectorXd unit = information.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const MatrixXd inverse = scaled.ldlt().solve(MatrixXd::Identity(k + 1, k + 1));
  const MatrixXd covariance = unit.asDiagonal() * inverse * unit.asDiagonal();
  return covariance.topLeftCorner(new_variances, new_variances);
}

}  // namespace silvafit::fit
