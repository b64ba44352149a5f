// SPDX-License-Identifier: MIT
// The expected information on variances of random effects that are zero.
#include "silvafit/fit/covariance_of_variances.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "likelihood/linearization.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Effects = std::vector<std::string>;

bool contains(const Effects& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// The smaller model with the random effects of the larger one added.
ModelSpecification joined(const FittedModel& larger, const FittedModel& smaller) {
  const bool is_nested =
      larger.specification.random.size() > 1 || smaller.specification.random.size() > 1;
  if (larger.specification.random.empty() || is_nested) {
    throw UsageError("variances are compared only if the larger model has one grouping");
  }
  if (larger.coefficient_names != smaller.coefficient_names) {
    throw UsageError("variances are compared only between models with the same coefficients");
  }
  ModelSpecification specification = smaller.specification;
  specification.random = larger.specification.random;
  return specification;
}

using Element = std::pair<Index, Index>;

/// The random effects of a fit with at most one term.
EstimatedEffects only_term(const FittedModel& fit) {
  return fit.random.empty() ? EstimatedEffects{} : fit.random.front();
}

/// Elements of the covariance of the larger model's random effects, which are the parameters of the
/// covariance of observations: new variances first, then those that the smaller model estimates.
struct Elements {
  std::vector<Element> all{};
  Index new_variances = 0;
};

Elements elements(const FittedModel& larger, const FittedModel& smaller) {
  const Effects& names = larger.random.front().names;
  const Effects known = only_term(smaller).names;
  Elements result;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!contains(known, names[i])) result.all.emplace_back(i, i);
  }
  result.new_variances = static_cast<Index>(result.all.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      if (!contains(known, names[i]) || !contains(known, names[j])) continue;
      const bool is_free =
          i == j || smaller.specification.random.front().covariance == Covariance::kGeneral;
      if (is_free) result.all.emplace_back(i, j);
    }
  }
  return result;
}

/// Positions of the smaller model's random effects among those of the larger one.
std::vector<Index> places_among(const Effects& larger, const Effects& smaller) {
  std::vector<Index> places;
  for (const std::string& name : smaller) {
    places.push_back(std::ranges::find(larger, name) - larger.begin());
  }
  return places;
}

/// The model linear around the estimates of the smaller fit.
Linearization linearized(const NonlinearModel& model,
                         const VarianceModel& variance,
                         const FittedModel& smaller) {
  LinearizationPoint point{
      .coefficients = smaller.estimate,
      .effects = MatrixXd::Zero(model.coefficient_count(), model.group_count()),
      .variance = variance.parameters(smaller.variance),
      .units = VectorXd::Ones(model.coefficient_count())};
  for (const RandomEffects& term : smaller.specification.random) {
    point.effects(model.coefficients_of(term), Eigen::all) = only_term(smaller).effects;
  }
  Linearization at;
  if (!Linearizer(model, variance).linearize(point, false, nullptr, at)) {
    throw UsageError(
        "the derivatives of the model are not finite at the estimates of the smaller fit");
  }
  return at;
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

/// The expected information on elements of the random effects' covariance and, last, on sigma^2.
class VarianceInformation {
 public:
  /// \param relative  (q x q) covariance of the random effects over sigma^2
  VarianceInformation(const std::vector<Element>& elements, MatrixXd relative, double sigma)
      : elements_(elements),
        relative_(std::move(relative)),
        precision_(1.0 / (sigma * sigma)),
        sum_(MatrixXd::Zero(count() + 1, count() + 1)) {}

  /// \param m     (q x q) Z'G^-2 Z of a group
  /// \param rows  of the group
  void add_group(const MatrixXd& m, Index rows) {
    const Index q = relative_.rows();
    // B = (D^-1 + M)^-1, also for a singular D.
    const MatrixXd b = (MatrixXd::Identity(q, q) + relative_ * m).partialPivLu().solve(relative_);
    const MatrixXd rest = MatrixXd::Identity(q, q) - b * m;
    const MatrixXd p = precision_ * m * rest;  // Z'V^-1 Z
    const MatrixXd twice =
        precision_ * precision_ * rest.transpose() * m * rest;  // Z'V^-1 G^2 V^-1 Z
    const Index k = count();
    for (Index i = 0; i < k; ++i) {
      for (Index j = 0; j < k; ++j) {
        sum_(i, j) += trace_of(
            p, p, elements_[static_cast<std::size_t>(i)], elements_[static_cast<std::size_t>(j)]);
      }
      const auto& [row, column] = elements_[static_cast<std::size_t>(i)];
      const double by_sigma = 0.5 * twice(row, column) * (row == column ? 1.0 : 2.0);
      sum_(i, k) += by_sigma;
      sum_(k, i) += by_sigma;
    }
    const MatrixXd hidden = b * m;
    sum_(k, k) += 0.5 * precision_ * precision_ *
                  (static_cast<double>(rows) - 2.0 * hidden.trace() + (hidden * hidden).trace());
  }

  const MatrixXd& sum() const { return sum_; }

 private:
  Index count() const { return static_cast<Index>(elements_.size()); }

  const std::vector<Element>& elements_;
  MatrixXd relative_;
  double precision_;
  MatrixXd sum_;
};

/// \throws NumericalError if variances are not identifiable from the observations
MatrixXd inverse_of(const MatrixXd& information, const Elements& elements, const Effects& names) {
  for (Index k = 0; k < elements.new_variances; ++k) {
    if (information(k, k) > 0.0) continue;
    const Index effect = elements.all[static_cast<std::size_t>(k)].first;
    throw NumericalError(
        fmt::format("the variance of {} is not identifiable: the mean does not depend on it at the "
                    "estimates of the smaller fit",
                    names[static_cast<std::size_t>(effect)]));
  }
  const Index size = information.rows();
  // In units that make the diagonal one, so that the sizes of the parameters do not matter.
  const VectorXd unit = information.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const Eigen::LDLT<MatrixXd> factor(scaled);
  // A smaller pivot is rounding error of the sums.
  constexpr double kSmallestPivot = 1e-12;
  const bool is_positive = scaled.allFinite() && factor.info() == Eigen::Success &&
                           factor.vectorD().minCoeff() > kSmallestPivot;
  if (!is_positive) {
    throw NumericalError(
        "the variances of the random effects and of the residuals are not identifiable at the "
        "estimates of the smaller fit");
  }
  const MatrixXd inverse = factor.solve(MatrixXd::Identity(size, size));
  return unit.asDiagonal() * inverse * unit.asDiagonal();
}

}  // namespace

MatrixXd covariance_of_variances(const FittedModel& larger,
                                 const FittedModel& smaller,
                                 const data::Table& table) {
  const NonlinearModel model(joined(larger, smaller), table);
  const Elements parameters = elements(larger, smaller);
  if (parameters.new_variances == 0) {
    throw UsageError("the larger model has no more random effects");
  }
  const VarianceModel variance(smaller.specification.variance, VarianceData::of(model));
  const double sigma = smaller.sigma / variance.sigma_factor(variance.parameters(smaller.variance));
  const Effects& names = larger.random.front().names;
  MatrixXd psi = MatrixXd::Zero(std::ssize(names), std::ssize(names));
  const EstimatedEffects effects = only_term(smaller);
  const std::vector<Index> known = places_among(names, effects.names);
  if (!known.empty()) psi(known, known) = effects.covariance;
  const Linearization at = linearized(model, variance, smaller);

  VarianceInformation information(parameters.all, psi * (1.0 / (sigma * sigma)), sigma);
  const std::vector<Index> places = model.random_coefficients().front();
  const Index width = at.model.moments.width();
  for (Index g = 0; g < model.group_count(); ++g) {
    const Eigen::Map<const MatrixXd> products(at.model.moments.term(g, 0), width, width);
    information.add_group(products(places, places),
                          model.group_begin(g + 1) - model.group_begin(g));
  }
  return inverse_of(information.sum(), parameters, names)
      .topLeftCorner(parameters.new_variances, parameters.new_variances);
}

}  // namespace silvafit::fit
