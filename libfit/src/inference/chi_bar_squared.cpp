// SPDX-License-Identifier: MIT
#include "silvafit/fit/chi_bar_squared.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Weights that are simple fractions, as fractions.
std::string weight_text(double weight) {
  for (const int denominator : {1, 2, 4, 8, 16}) {
    const double numerator = weight * denominator;
    if (std::abs(numerator - std::round(numerator)) > 1e-9) continue;
    return denominator == 1 ? "" : fmt::format("{:.0f}/{} ", numerator, denominator);
  }
  return fmt::format("{:.3f} ", weight);
}

/// The number of positive components of the projection of y on the positive quadrant, in the metric
/// of P. The quadratic program has few variables, so that all supports can be tried: the solution
/// has positive components and fulfils the optimality conditions for the others.
int positive_components(const VectorXd& y, const MatrixXd& precision) {
  const auto k = static_cast<int>(y.size());
  const VectorXd right = precision * y;
  for (unsigned support = 0; support < (1U << static_cast<unsigned>(k)); ++support) {
    std::vector<Index> in;
    for (int i = 0; i < k; ++i) {
      if ((support >> static_cast<unsigned>(i) & 1U) != 0) in.push_back(i);
    }
    VectorXd point = VectorXd::Zero(k);
    if (!in.empty()) {
      const Eigen::LLT<MatrixXd> factor(precision(in, in));
      if (factor.info() != Eigen::Success) continue;
      const VectorXd values = factor.solve(right(in));
      if ((values.array() <= 0.0).any()) continue;
      point(in) = values;
    }
    const VectorXd slope = right - precision * point;
    bool is_optimal = true;
    for (int i = 0; i < k; ++i) {
      const bool is_in = (support >> static_cast<unsigned>(i) & 1U) != 0;
      if (!is_in && slope[i] > 0.0) is_optimal = false;
    }
    if (is_optimal) return static_cast<int>(in.size());
  }
  return 0;
}

}  // namespace

double ChiBarSquared::upper_tail(double x) const {
  if (!(x > 0.0)) return std::isnan(x) ? x : 1.0;
  if (std::isinf(x)) return 0.0;
  double result = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const int freedom = base + static_cast<int>(i);
    if (freedom == 0 || weights[i] == 0.0) continue;
    result += weights[i] *
              boost::math::cdf(boost::math::complement(boost::math::chi_squared(freedom), x));
  }
  return result;
}

std::string ChiBarSquared::text() const {
  if (weights.size() == 1) {
    return fmt::format("chi-squared with {} degree{} of freedom", base, base == 1 ? "" : "s");
  }
  std::string result;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] == 0.0) continue;
    if (!result.empty()) result += " + ";
    result += fmt::format("{}chi-squared({})", weight_text(weights[i]), base + static_cast<int>(i));
  }
  return result;
}

ChiBarSquared independent_variances(int k) {
  ChiBarSquared result{.weights = {std::pow(0.5, k)}};
  for (int i = 1; i <= k; ++i) {
    result.weights.push_back(result.weights.back() * (k - i + 1) / i);
  }
  return result;
}

ChiBarSquared correlated_variances(const Eigen::Ref<const MatrixXd>& covariance,
                                   std::uint64_t seed,
                                   int draws) {
  const Index k = covariance.rows();
  constexpr Index kMost = 12;
  const Eigen::LLT<MatrixXd> factor(covariance);
  if (k == 0 || k > kMost || covariance.cols() != k || factor.info() != Eigen::Success ||
      !covariance.allFinite()) {
    throw UsageError(fmt::format(
        "the covariance matrix of the variances (1 to {}) must be square and positive definite",
        kMost));
  }
  if (k == 1) return independent_variances(1);
  if (k == 2) {
    // The quadrant's angle in the metric of the inverse.
    const double correlation = covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1));
    const double both = std::acos(-correlation) / (2.0 * std::numbers::pi);
    return {.weights = {0.5 - both, 0.5, both}};
  }
  const MatrixXd precision = factor.solve(MatrixXd::Identity(k, k));
  ChiBarSquared result{.weights = std::vector<double>(static_cast<std::size_t>(k) + 1, 0.0)};
  Random random(seed);
  VectorXd z(k);
  for (int draw = 0; draw < draws; ++draw) {
    for (double& value : z) value = random.normal();
    const VectorXd y = factor.matrixL() * z;
    result.weights[static_cast<std::size_t>(positive_components(y, precision))] += 1.0 / draws;
  }
  return result;
}

}  // namespace silvafit::fit
