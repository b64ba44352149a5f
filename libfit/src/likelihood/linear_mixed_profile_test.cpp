// SPDX-License-Identifier: MIT
#include "likelihood/linear_mixed_profile.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "silvafit/base/random.hpp"

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace silvafit::fit;

namespace {

/// 23 observations in groups of 9, 1, 8 and 5, the first three of which are a cluster; three
/// coefficients.
struct Example {
  std::vector<Index> group_begin{0, 9, 10, 18, 23};
  RandomColumns random{.terms = {{0, 2}}, .cluster_begin = {0, 3, 4}};
  MatrixXd design = MatrixXd(23, 3);
  VectorXd working = VectorXd(23);
  ArrayXd log_slope = ArrayXd::LinSpaced(23, -0.8, 1.1);  ///< d log g / d variance parameter
  bool restricted = false;
  double center = 0.0;

  /// \param of_clusters  columns of the effects of clusters; none: one term
  explicit Example(const std::vector<Index>& of_clusters = {}) {
    if (!of_clusters.empty()) {
      random.terms = {of_clusters, {0, 2}};
      random.of_groups = {{0, 0, 0, 1}, {0, 1, 2, 3}};
    }
    silvafit::Random numbers(11);
    for (Index i = 0; i < 23; ++i) {
      design(i, 0) = 1.0;
      design(i, 1) = numbers.normal();
      design(i, 2) = numbers.uniform(0.0, 2.0);
      working[i] = numbers.normal(1.0 + design(i, 2), 1.5);
    }
  }

  ArrayXd weight(double parameter) const { return (-2.0 * parameter * log_slope).exp(); }

  /// The cross products at a variance parameter, with their two derivatives.
  LinearMixedModel model(double parameter) const {
    LinearMixedModel result{.moments = GroupMoments(4, 4, 1, {{0, 0}}),
                            .random = random,
                            .observations = 23,
                            .restricted = restricted};
    result.moments.set_center(VectorXd::Constant(1, center));
    result.moments.sum_log() << parameter * log_slope.sum(), log_slope.sum(), 0.0;
    MatrixXd all(23, 4);
    all << design, working;
    for (Index group = 0; group < 4; ++group) {
      const Index begin = group_begin[static_cast<std::size_t>(group)];
      const Index rows = group_begin[static_cast<std::size_t>(group) + 1] - begin;
      const MatrixXd of = all.middleRows(begin, rows);
      const ArrayXd slope = log_slope.segment(begin, rows);
      ArrayXd factor = weight(parameter).segment(begin, rows);
      for (Index term = 0; term < 3; ++term, factor *= -2.0 * slope) {
        Eigen::Map<MatrixXd>(result.moments.term(group, term), 4, 4) =
            of.transpose() * factor.matrix().asDiagonal() * of;
      }
    }
    return result;
  }

  /// V relative to sigma^2, whole.
  MatrixXd covariance(double parameter, const RelativeFactors& factors) const {
    MatrixXd v = MatrixXd(weight(parameter).inverse().matrix().asDiagonal());
    const auto add = [&](Index begin, Index rows, const auto& columns, const MatrixXd& l) {
      const MatrixXd z = design.middleRows(begin, rows)(Eigen::all, columns);
      v.block(begin, begin, rows, rows) += z * l * l.transpose() * z.transpose();
    };
    for (std::size_t j = 0; j < 4; ++j) {
      add(group_begin[j], group_begin[j + 1] - group_begin[j], random.terms.back(), factors.back());
    }
    if (random.terms.size() > 1) {
      add(0, 18, random.terms.front(), factors.front());
      add(18, 5, random.terms.front(), factors.front());
    }
    return v;
  }

  double dense_minus_log_likelihood(double parameter, const RelativeFactors& factors) const {
    const Eigen::LLT<MatrixXd> decomposed(covariance(parameter, factors));
    const MatrixXd x = decomposed.matrixL().solve(design);
    const VectorXd w = decomposed.matrixL().solve(working);
    const MatrixXd information = x.transpose() * x;
    const VectorXd beta = information.ldlt().solve(x.transpose() * w);
    const double freedom = restricted ? 20.0 : 23.0;
    const double sigma2 = (w - x * beta).squaredNorm() / freedom;
    return 0.5 * freedom * (std::log(2.0 * std::numbers::pi * sigma2) + 1.0) +
           MatrixXd(decomposed.matrixL()).diagonal().array().log().sum() +
           (restricted ? 0.5 * std::log(information.determinant()) : 0.0);
  }
};

RelativeFactors example_factors(const Example& example, double size) {
  const MatrixXd of_groups{{0.8, 0.0}, {-0.3, 0.5}};
  RelativeFactors factors{size * of_groups};
  if (example.random.terms.size() > 1) {
    const MatrixXd of_clusters{{0.6, 0.0}, {0.4, 0.9}};
    const auto count = static_cast<Index>(example.random.terms.front().size());
    factors.insert(factors.begin(), size * of_clusters.topLeftCorner(count, count));
  }
  return factors;
}

/// One term; two terms with different or common effects; both likelihoods.
std::vector<Example> examples() {
  std::vector<Example> result;
  for (const std::vector<Index>& of_clusters :
       {std::vector<Index>{}, std::vector<Index>{1}, std::vector<Index>{0, 1}}) {
    for (const bool restricted : {false, true}) {
      result.emplace_back(of_clusters);
      result.back().restricted = restricted;
      result.back().center = restricted ? 0.15 : 0.0;
    }
  }
  return result;
}

double value_at(const Example& example, double displacement, const RelativeFactors& factors) {
  return profile(example.model(0.4), factors, VectorXd::Constant(1, displacement), false)
      .minus_log_likelihood;
}

}  // namespace

TEST_CASE("the profile likelihood is that of the dense covariance matrix") {
  for (const Example& example : examples()) {
    for (const double size : {1.0, 1e-3, 0.0}) {
      const RelativeFactors factors = example_factors(example, size);
      // Rounding of a 23 x 23 Cholesky factorization.
      CHECK(value_at(example, 0.0, factors) ==
            Approx(example.dense_minus_log_likelihood(0.4, factors)).epsilon(1e-12));
    }
  }
}

TEST_CASE("random effects are those of the dense covariance matrix") {
  for (const Example& example : examples()) {
    const RelativeFactors factors = example_factors(example, 1.0);
    const LinearMixedProfile at = profile(example.model(0.4), factors, VectorXd::Zero(1), true);
    const MatrixXd v = example.covariance(0.4, factors);
    const VectorXd scaled = v.ldlt().solve(example.working - example.design * at.coefficients);
    // b = D Z'V^-1 (w - X beta), for the first group of each term.
    for (std::size_t t = 0; t < factors.size(); ++t) {
      const Index rows = t + 1 == factors.size() ? 9 : 18;
      const MatrixXd z = example.design.topRows(rows)(Eigen::all, example.random.terms[t]);
      const VectorXd effects =
          factors[t] * factors[t].transpose() * z.transpose() * scaled.head(rows);
      CHECK((factors[t] * at.spherical[t].col(0) - effects).norm() < 1e-12);
    }
  }
}

TEST_CASE("gradients by all variance components equal differences of the values") {
  // Central differences with step 1e-5 are accurate to about 1e-9 here.
  constexpr double kStep = 1e-5;
  for (const Example& example : examples()) {
    const RelativeFactors factors = example_factors(example, 1.0);
    const double displacement = 0.05;
    const LinearMixedProfile at =
        profile(example.model(0.4), factors, VectorXd::Constant(1, displacement), true);
    for (std::size_t t = 0; t < factors.size(); ++t) {
      for (Index column = 0; column < factors[t].cols(); ++column) {
        for (Index row = column; row < factors[t].rows(); ++row) {
          RelativeFactors above = factors;
          RelativeFactors below = factors;
          above[t](row, column) += kStep;
          below[t](row, column) -= kStep;
          const double difference =
              (value_at(example, displacement, above) - value_at(example, displacement, below)) /
              (2.0 * kStep);
          CHECK(at.by_factor[t](row, column) == Approx(difference).epsilon(1e-7).margin(1e-8));
        }
      }
    }
    const double difference = (value_at(example, displacement + kStep, factors) -
                               value_at(example, displacement - kStep, factors)) /
                              (2.0 * kStep);
    CHECK(at.by_variance[0] == Approx(difference).epsilon(1e-7).margin(1e-8));
    // dF/dL = 2 dF/dD L, lower triangle.
    for (std::size_t t = 0; t < factors.size(); ++t) {
      const MatrixXd by_factor = 2.0 * at.by_covariance[t] * factors[t];
      const Index last = by_factor.rows() - 1;
      CHECK(by_factor(last, 0) == Approx(at.by_factor[t](last, 0)).epsilon(1e-12));
    }
  }
}

TEST_CASE("the series in the variance parameter agrees with the likelihood to second order") {
  for (const Example& example : examples()) {
    const RelativeFactors factors = example_factors(example, 1.0);
    // Third-order terms: 1e-3 cubed, times some tens of observations.
    CHECK(value_at(example, 1e-3, factors) ==
          Approx(example.dense_minus_log_likelihood(0.401, factors)).margin(1e-7));
  }
}

TEST_CASE("restricted likelihood with the unit of a column does not depend on that unit") {
  Example example({1});
  example.restricted = true;
  const RelativeFactors factors = example_factors(example, 1.0);
  LinearMixedModel model = example.model(0.4);
  const double before = profile(model, factors, VectorXd::Zero(1), false).minus_log_likelihood;
  // The second column a hundred times smaller, and its effects' factor a hundred times larger.
  model.moments.divide_columns(Eigen::Vector3d(1.0, 100.0, 1.0));
  model.log_units = 2.0 * std::log(100.0);
  RelativeFactors moved = factors;
  moved.front() *= 100.0;
  CHECK(profile(model, moved, VectorXd::Zero(1), false).minus_log_likelihood ==
        Approx(before).epsilon(1e-12));
}

TEST_CASE("expected squares are those of the residuals") {
  const Example example({0, 1});
  const RelativeFactors factors = example_factors(example, 1.0);
  const LinearMixedModel model = example.model(0.4);
  const LinearMixedProfile at = profile(model, factors, VectorXd::Zero(1), true);
  const VectorXd squares = expected_squares(model, factors, at);
  const VectorXd b = factors.back() * at.spherical.back().col(3);
  const VectorXd u = factors.front() * at.spherical.front().col(1);
  const MatrixXd x = example.design.bottomRows(5);
  const VectorXd residual = example.working.tail(5) - x * at.coefficients -
                            x(Eigen::all, example.random.terms.back()) * b -
                            x(Eigen::all, example.random.terms.front()) * u;
  CHECK(squares[3] ==
        Approx((example.weight(0.4).tail(5) * residual.array().square()).sum()).epsilon(1e-12));
  // Their sum with the penalty is S.
  const double penalized =
      squares.sum() + at.spherical.back().squaredNorm() + at.spherical.front().squaredNorm();
  CHECK(penalized == Approx(at.sum_of_squares).epsilon(1e-12));
}
