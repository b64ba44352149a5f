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

}  // namespace

std::vector<VectorXd> exchanged_minima(const NonlinearModel& model, const VectorXd& minimum) {
  // The number of pairs of exchanges grows with the fourth power of the number of coefficients.
  constexpr Index kMostCoefficients = 10;
  const Index p = minimum.size();
  if (p < 2 || p > kMostCoefficients) return {};
  SameMean same(model, minimum);
  for (Index i = 0; i < p; ++i) {
    for (Index j = 0; j < i; ++j) {
      VectorXd once = minimum;
      std::swap(once[i], once[j]);
      same.consider(once);
      for (Index k = 0; k < p; ++k) {
        VectorXd turned = once;
        turned[k] = -turned[k];
        same.consider(turned);
      }
      for (Index k = 0; k < i; ++k) {
        for (Index l = 0; l < k; ++l) {
          if (k == j || l == j) continue;
          VectorXd twice = once;
          std::swap(twice[k], twice[l]);
          same.consider(twice);
        }
      }
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
