// SPDX-License-Identifier: MIT
#include "correlation/correlation_structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "correlation/pair_correlations.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = Correlation::Kind;

/// A range that is so many times the largest distance is without bound.
constexpr double kFar = 50.0;
/// The logarithm of the longest range in units. At longer ones correlations differ from 1 by
/// rounding errors, and a search would go on without end.
constexpr double kLongest = 18.4;  // 1e8

double bounded(double log_range) { return std::min(log_range, kLongest); }

double logistic(double x) { return 1.0 / (1.0 + std::exp(-x)); }
double logit(double share) { return std::log(share / (1.0 - share)); }

std::vector<std::string> names_of(const Correlation& of, std::size_t times) {
  std::vector<std::string> names;
  switch (of.kind) {
    case Kind::kAr1:
    case Kind::kCar1:
      return {"phi"};
    case Kind::kCompoundSymmetry:
      return {"rho"};
    case Kind::kArma:
      for (int k = 1; k <= of.autoregressive; ++k) names.push_back(fmt::format("phi{}", k));
      for (int k = 1; k <= of.moving_average; ++k) names.push_back(fmt::format("theta{}", k));
      return names;
    case Kind::kSymmetric:
      for (std::size_t i = 1; i <= times; ++i) {
        for (std::size_t j = i + 1; j <= times; ++j) {
          names.push_back(fmt::format("cor({}, {})", i, j));
        }
      }
      return names;
    default:
      names = {"range"};
      if (of.has_nugget) names.emplace_back("nugget");
      return names;
  }
}

}  // namespace

CorrelationStructure::CorrelationStructure(Correlation correlation, CorrelationScale scale)
    : correlation_(std::move(correlation)),
      scale_(std::move(scale)),
      names_(names_of(correlation_, scale_.times.size())) {}

CorrelationStructure::CorrelationStructure(const CorrelationEstimate& estimate, double farthest)
    : CorrelationStructure(estimate.correlation,
                           {.unit = estimate.unit,
                            .farthest = farthest,
                            .largest = estimate.largest,
                            .times = estimate.times}) {}

std::vector<VectorXd> CorrelationStructure::starts() const {
  const Index m = parameter_count();
  std::vector<VectorXd> result;
  switch (correlation_.kind) {
    case Kind::kAr1:
    case Kind::kArma:
    case Kind::kSymmetric:
      // Moving averages and symmetric structures have one maximum near.
      result.push_back(VectorXd::Zero(m));
      if (correlation_.kind == Kind::kSymmetric) return result;
      for (const double nearest : {-0.5, 0.5, 0.9}) {
        if (nearest < 0.0 && scale_.is_even) continue;
        const double phi = std::copysign(std::pow(std::abs(nearest), 1.0 / scale_.unit), nearest);
        result.push_back(VectorXd::Zero(m));
        result.back()[0] = 2.0 * std::atanh(phi);
      }
      return result;
    case Kind::kCompoundSymmetry:
      for (const double rho : {0.0, 0.3, 0.7}) {
        result.push_back(unconstrained(VectorXd::Constant(1, rho)));
      }
      return result;
    default: {
      // Ranges from that of independent rows to that of the whole extent, and one without bound.
      const double top = std::log(std::max(2.0, scale_.farthest / scale_.unit));
      // A factor of two; a linear correlation may have a maximum between any two distances of rows.
      const double step = correlation_.kind == Kind::kLinear ? 0.1 : 0.7;
      const auto add = [&](double log_range) {
        for (const double nugget : {0.001, 0.1, 0.5}) {
          result.push_back(VectorXd::Constant(m, log_range));
          if (m == 1) break;
          result.back()[1] = logit(nugget);
        }
      };
      for (double at = std::log(0.25); at < top + step; at += step) add(at);
      add(std::log(2.0 * kFar * scale_.farthest / scale_.unit));
      return result;
    }
  }
}

VectorXd CorrelationStructure::natural(const VectorXd& parameters) const {
  VectorXd result = parameters;
  switch (correlation_.kind) {
    case Kind::kAr1:
      result[0] = std::tanh(0.5 * parameters[0]);
      return result;
    case Kind::kCar1:
      result[0] = std::exp(-std::exp(-bounded(parameters[0])) / scale_.unit);
      return result;
    case Kind::kArma:
      return arma_coefficients(correlation_, parameters);
    case Kind::kCompoundSymmetry: {
      const double low = limits(0).first;
      result[0] = low + (1.0 - low) * logistic(parameters[0]);
      return result;
    }
    case Kind::kSymmetric:
      return symmetric_correlations(std::ssize(scale_.times), parameters);
    default:
      result[0] = scale_.unit * std::exp(bounded(parameters[0]));
      if (correlation_.has_nugget) result[1] = logistic(parameters[1]);
      return result;
  }
}

VectorXd CorrelationStructure::unconstrained(const VectorXd& natural) const {
  VectorXd result = natural;
  switch (correlation_.kind) {
    case Kind::kAr1:
      result[0] = 2.0 * std::atanh(natural[0]);
      return result;
    case Kind::kCar1:
      result[0] = -std::log(-std::log(natural[0]) * scale_.unit);
      return result;
    case Kind::kArma:
      return arma_parameters(correlation_, natural);
    case Kind::kCompoundSymmetry: {
      const double low = limits(0).first;
      result[0] = logit((natural[0] - low) / (1.0 - low));
      return result;
    }
    case Kind::kSymmetric:
      return symmetric_parameters(std::ssize(scale_.times), natural);
    default:
      result[0] = std::log(natural[0] / scale_.unit);
      if (correlation_.has_nugget) result[1] = logit(natural[1]);
      return result;
  }
}

bool CorrelationStructure::has_range() const {
  return correlation_.kind == Kind::kCar1 || correlation_.kind >= Kind::kExponential;
}

bool CorrelationStructure::has_unbounded_range(const VectorXd& parameters) const {
  return has_range() && scale_.unit * std::exp(parameters[0]) > kFar * scale_.farthest;
}

VectorXd CorrelationStructure::lifted(VectorXd parameters) const {
  if (!has_range()) return parameters;
  // At a smaller range than this, or a logit beyond it, correlations change by less than a
  // millionth.
  constexpr double kMillionth = 13.8;
  constexpr double kInside = 2.2;  // a nugget of 0.1 or 0.9
  if (parameters[0] < -std::log(kMillionth)) parameters[0] = 0.0;
  if (correlation_.has_nugget && std::abs(parameters[1]) > kMillionth) {
    parameters[1] = std::copysign(kInside, parameters[1]);
  }
  return parameters;
}

bool CorrelationStructure::is_separable() const {
  return parameter_count() < 2 || correlation_.kind >= Kind::kExponential;
}

std::pair<double, double> CorrelationStructure::limits(Index k) const {
  switch (correlation_.kind) {
    case Kind::kCar1:
      return {0.0, 1.0};
    case Kind::kCompoundSymmetry:
      return {-1.0 / static_cast<double>(std::max<Index>(1, scale_.largest - 1)), 1.0};
    case Kind::kAr1:
    case Kind::kSymmetric:
      return {-1.0, 1.0};
    case Kind::kArma: {
      // Of a coefficient whose other ones are 0; binomial coefficients bound those of all.
      const double most = names_[static_cast<std::size_t>(k)].starts_with("phi")
                              ? correlation_.autoregressive
                              : correlation_.moving_average;
      const double bound = std::pow(2.0, most) - 1.0;
      return {-bound, bound};
    }
    default:
      return {0.0, k == 0 ? std::numeric_limits<double>::infinity() : 1.0};
  }
}

CorrelationEstimate CorrelationStructure::estimate(const VectorXd& parameters) const {
  return {.correlation = correlation_,
          .names = names_,
          .values = natural(parameters),
          .times = scale_.times,
          .unit = scale_.unit,
          .largest = scale_.largest};
}

double CorrelationStructure::place(double time) const {
  if (correlation_.kind != Kind::kSymmetric) return time;
  const auto found = std::ranges::lower_bound(scale_.times, time);
  if (found == scale_.times.end() || *found != time) return -1.0;
  return static_cast<double>(found - scale_.times.begin());
}

std::unique_ptr<PairCorrelation> CorrelationStructure::at(const VectorXd& parameters) const {
  const VectorXd value = natural(parameters);
  switch (correlation_.kind) {
    case Kind::kAr1:
      return first_order(value[0], 0.5 * (1.0 - value[0] * value[0]));
    case Kind::kCar1:
      return by_distance(Kind::kExponential,
                         scale_.unit * std::exp(bounded(parameters[0])),
                         kNaN,
                         parameters[0] < kLongest);
    case Kind::kArma:
      return moving_average(correlation_, parameters, std::lround(scale_.farthest));
    case Kind::kCompoundSymmetry:
      return compound_symmetry(value[0], limits(0).first);
    case Kind::kSymmetric:
      return symmetric(std::ssize(scale_.times), parameters);
    default:
      return by_distance(correlation_.kind,
                         value[0],
                         correlation_.has_nugget ? value[1] : kNaN,
                         parameters[0] < kLongest);
  }
}

bool CorrelationStructure::is_markov() const {
  const bool is_line = correlation_.kind == Kind::kExponential && !correlation_.has_nugget &&
                       correlation_.columns.size() == 1;
  return correlation_.kind == Kind::kAr1 || correlation_.kind == Kind::kCar1 || is_line;
}

std::unique_ptr<CorrelationFactor> CorrelationStructure::factor(const MatrixXd& places,
                                                                const PairCorrelation& of) const {
  const Index n = places.rows();
  const Index m = parameter_count();
  VectorXd slopes(m);
  const auto between = [&](Index i, Index j) {
    const double distance = (places.row(i) - places.row(j)).norm();
    return of.between(distance, places(i, 0), places(j, 0), slopes.data());
  };
  if (is_markov()) {
    VectorXd before = VectorXd::Zero(n);
    MatrixXd by(n, m);
    for (Index i = 1; i < n; ++i) {
      before[i] = between(i, i - 1);
      by.row(i) = slopes;
    }
    return markov_factor(std::move(before), std::move(by));
  }
  MatrixXd correlation = MatrixXd::Identity(n, n);
  std::vector<MatrixXd> all_slopes(static_cast<std::size_t>(m), MatrixXd::Zero(n, n));
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j) {
      correlation(i, j) = correlation(j, i) = between(i, j);
      for (Index k = 0; k < m; ++k) {
        MatrixXd& by = all_slopes[static_cast<std::size_t>(k)];
        by(i, j) = by(j, i) = slopes[k];
      }
    }
  }
  return dense_factor(correlation, std::move(all_slopes));
}

}  // namespace silvafit::fit
