// SPDX-License-Identifier: MIT
#include "least_squares/exchanged_minima.hpp"

#include <cmath>
#include <utility>

#include "least_squares/levenberg_marquardt.hpp"
#include "least_squares/location_coefficients.hpp"
#include "least_squares/start_search.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Collects points with the same mean as a minimum.
class SameMean {
 public:
  SameMean(const NonlinearModel& model, const VectorXd& minimum)
      : model_(model.subset(even_sample(model.response(), kSample))), minimum_(minimum) {
    model_.evaluate(minimum, mean_, nullptr, workspace_);
  }

  void consider(const VectorXd& point) {
    // The minimum itself, or a point with equal values, is not new.
    if ((point - minimum_).cwiseAbs().maxCoeff() <= kRounding * minimum_.cwiseAbs().maxCoeff()) {
      return;
    }
    VectorXd mean;
    model_.evaluate(point, mean, nullptr, workspace_);
    if ((mean - mean_).norm() <= kRounding * mean_.norm()) found_.push_back(point);
  }

  std::vector<VectorXd> found() && { return std::move(found_); }

 private:
  // Enough rows to distinguish functions.
  static constexpr Index kSample = 50;
  static constexpr double kRounding = 1e-9;

  NonlinearModel model_;
  VectorXd minimum_;
  VectorXd mean_;
  NonlinearModel::Workspace workspace_;
  std::vector<VectorXd> found_;
};

/// Considers all exchanges of up to a number of disjoint pairs of the coefficients from a place on.
void exchange_pairs(
    VectorXd& point, std::vector<bool>& is_taken, Index from, int pairs, SameMean& same) {
  const Index p = point.size();
  if (pairs == 0) return;
  for (Index i = from; i < p; ++i) {
    if (is_taken[static_cast<std::size_t>(i)]) continue;
    for (Index j = i + 1; j < p; ++j) {
      if (is_taken[static_cast<std::size_t>(j)]) continue;
      std::swap(point[i], point[j]);
      same.consider(point);
      is_taken[static_cast<std::size_t>(j)] = true;
      exchange_pairs(point, is_taken, i + 1, pairs - 1, same);
      is_taken[static_cast<std::size_t>(j)] = false;
      std::swap(point[i], point[j]);
    }
  }
}

}  // namespace

std::vector<VectorXd> exchanged_minima(const NonlinearModel& model, const VectorXd& minimum) {
  // With four pairs the number of exchanges is 763 for eight coefficients, with two it is 675 for
  // ten.
  constexpr Index kMostCoefficients = 10;
  constexpr Index kFewCoefficients = 8;
  const Index p = minimum.size();
  if (p < 2 || p > kMostCoefficients) return {};
  SameMean same(model, minimum);
  VectorXd point = minimum;
  std::vector<bool> is_taken(static_cast<std::size_t>(p), false);
  exchange_pairs(point, is_taken, 0, p <= kFewCoefficients ? 4 : 2, same);
  for (Index i = 0; i < p; ++i) {
    for (Index j = 0; j < i; ++j) {
      std::swap(point[i], point[j]);
      for (Index k = 0; k < p; ++k) {
        const double value = point[k];
        for (const double other : {-value, 1.0 - value}) {
          point[k] = other;
          same.consider(point);
        }
        point[k] = value;
      }
      std::swap(point[i], point[j]);
    }
  }
  return std::move(same).found();
}

std::vector<VectorXd> exchanged_locations(const NonlinearModel& model, const VectorXd& minimum) {
  constexpr Index kSample = 200;
  constexpr double kSameMinimum = 1e-4;
  constexpr double kSamePlace = 1e-3;
  const std::vector<LocationCoefficient> locations = location_coefficients(model);
  if (locations.size() < 2) return {};
  const NonlinearModel part = model.subset(even_sample(model.response(), kSample));
  ProjectedModel projected(part);
  const auto minimum_from = [&](const VectorXd& point) {
    return descend(
        projected, projected.nonlinear_part(point), {.maximum_iterations = 100, .tolerance = 1e-9});
  };
  const Descent lowest = minimum_from(minimum);
  std::vector<VectorXd> result;
  for (std::size_t i = 0; i < locations.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      VectorXd point = minimum;
      std::swap(point[locations[i].coefficient], point[locations[j].coefficient]);
      const Descent found = minimum_from(point);
      if (!(found.sum_of_squares <= lowest.sum_of_squares * (1.0 + kSameMinimum))) continue;
      const VectorXd change = (found.coefficients - minimum).cwiseAbs();
      if ((change.array() <= kSamePlace * minimum.array().abs()).all()) continue;
      result.push_back(found.coefficients);
    }
  }
  return result;
}

}  // namespace silvafit::fit
