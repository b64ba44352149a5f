// SPDX-License-Identifier: MIT
#include "likelihood/marginal_likelihood.hpp"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "silvafit/data/table.hpp"
#include "test_support/nested_trees.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace silvafit::fit;
using silvafit::data::Table;

namespace {

/// Trees of some plots in two stands, with a covariate, a species and a height.
Table nested_stands(int plots, int per_plot) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<NestedTree> trees;
  for (int i = 0; i < plots; ++i) {
    const double effect = 2.0 * normal(random);
    for (int k = 0; k < per_plot + i % 3; ++k) {
      NestedTree tree{.stand = i < plots / 2 ? "low" : "high", .plot = "p" + std::to_string(i)};
      tree.species = k % 2 == 0 ? "fir" : "oak";
      tree.dbh_cm = 5.0 + 30.0 * uniform(random);
      tree.crowding = uniform(random);
      const double rate = 0.07 - 0.02 * tree.crowding;
      const double mean = 1.3 + (20.0 + effect) * (1.0 - std::exp(-rate * tree.dbh_cm));
      tree.h_m = mean + 0.1 * mean * normal(random);
      trees.push_back(tree);
    }
  }
  return table_of(trees);
}

ModelSpecification curve(const Table& table,
                         const char* random,
                         const char* variance,
                         const char* correlation = "none") {
  ModelSpecification model = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {"b ~ 1 + C"}, table);
  add_random_effects(model, random, table);
  model.variance = parse_variance_function(variance);
  if (std::string_view(correlation) != "none") model.correlation = parse_correlation(correlation);
  return model;
}

/// A model with its marginal likelihood, and its parameters as one vector.
struct Setting {
  NonlinearModel model;
  VarianceModel variance;
  MarginalLikelihood likelihood;
  MarginalPoint at{};

  Setting(const ModelSpecification& specification,
          const Table& table,
          Curvature curvature,
          int points = 1)
      : model(specification, table),
        variance(specification.variance, VarianceData::of(model)),
        likelihood(model, variance, curvature, points) {
    at.observation = {.beta = Eigen::Vector3d(20.0, 0.07, -0.02),
                      .variance = variance.start(),
                      .log_sigma = std::log(1.3)};
    const std::vector<std::vector<Index>>& terms = likelihood.places().terms;
    for (std::size_t t = 0; t < terms.size(); ++t) {
      at.factors.push_back(lower(terms[t], t + 1 == terms.size() ? 0.09 : 0.06));
    }
  }

  /// A factor with standard deviations relative to the coefficients, and some correlation.
  MatrixXd lower(const std::vector<Index>& coefficients, double share) const {
    const auto size = static_cast<Index>(coefficients.size());
    MatrixXd factor = MatrixXd::Zero(size, size);
    for (Index i = 0; i < size; ++i) {
      for (Index j = 0; j <= i; ++j) {
        const double unit = at.observation.beta[coefficients[static_cast<std::size_t>(i)]];
        factor(i, j) = share * unit * (i == j ? 1.0 : 0.4);
      }
    }
    return factor;
  }

  double value() { return likelihood.evaluate(at, false).minus_log_likelihood; }

  /// The central difference of the value in one number.
  double difference(double& number) {
    const double kept = number;
    // Relative to the number; modes that are exact to 1e-9 give values exact to about 1e-10.
    const double step = 1e-3 * std::max(1e-3, std::abs(kept));
    double sum = 0.0;
    for (const auto& [times, weight] :
         {std::pair{1.0, 8.0}, {-1.0, -8.0}, {2.0, -1.0}, {-2.0, 1.0}}) {
      number = kept + times * step;
      sum += weight * value();
    }
    number = kept;
    return sum / (12.0 * step);
  }
};

void check_gradient(Setting& setting) {
  const MarginalValue exact = setting.likelihood.evaluate(setting.at, true);
  REQUIRE(std::isfinite(exact.minus_log_likelihood));
  // Fourth-order differences with steps of 1e-3 are accurate to about 1e-7 of the value's scale.
  const auto check = [&](double derivative, double& number) {
    const double scale = std::max(1e-3, std::abs(number));
    CHECK(derivative * scale ==
          Approx(setting.difference(number) * scale).epsilon(1e-7).margin(2e-7));
  };
  for (Index j = 0; j < exact.by_beta.size(); ++j) {
    check(exact.by_beta[j], setting.at.observation.beta[j]);
  }
  for (Index e = 0; e < exact.by_variance.size(); ++e) {
    check(exact.by_variance[e], setting.at.observation.variance[e]);
  }
  check(exact.by_log_sigma, setting.at.observation.log_sigma);
  for (std::size_t t = 0; t < exact.by_factors.size(); ++t) {
    for (Index i = 0; i < exact.by_factors[t].rows(); ++i) {
      for (Index j = 0; j <= i; ++j) {
        check(exact.by_factors[t](i, j), setting.at.factors[t](i, j));
      }
    }
  }
}

/// -log density of normal observations with a dense covariance matrix.
double normal_minus_log_density(const VectorXd& residual, const MatrixXd& covariance) {
  const Eigen::LLT<MatrixXd> factor(covariance);
  const VectorXd white = factor.matrixL().solve(residual);
  return 0.5 * white.squaredNorm() + MatrixXd(factor.matrixL()).diagonal().array().log().sum() +
         0.5 * static_cast<double>(residual.size()) * std::log(2.0 * std::numbers::pi);
}

}  // namespace

TEST_CASE("gradients of marginal likelihoods equal differences of their values") {
  const Table table = nested_stands(6, 5);
  const char* const variance = GENERATE("none",
                                        "power",
                                        "exponential",
                                        "constant-plus-power",
                                        "power(dbh)",
                                        "stratum(species) * power(fitted | species)");
  const Curvature curvature =
      GENERATE(Curvature::kFull, Curvature::kExpected, Curvature::kFirstOrder);
  const char* const random = GENERATE("a | plot", "a + b:C | plot", "a | stand; a + b | plot");
  INFO(variance << ", " << random << ", curvature " << static_cast<int>(curvature));
  Setting setting(curve(table, random, variance), table, curvature);
  check_gradient(setting);
}

TEST_CASE("gradients of marginal likelihoods of correlated residuals equal differences") {
  const Table table = nested_stands(5, 5);
  const char* const variance = GENERATE("none", "power", "stratum(species) * power(fitted)");
  const char* const correlation =
      GENERATE("car1(dbh)", "exponential(dbh; nugget)", "compound-symmetry", "car1(dbh | species)");
  const Curvature curvature =
      GENERATE(Curvature::kFull, Curvature::kExpected, Curvature::kFirstOrder);
  const char* const random = GENERATE("a + b:C | plot", "a | stand; a + b | plot");
  const int points = random[0] == 'a' && random[2] == '+' ? GENERATE(1, 3) : 1;
  if (points > 1 && curvature != Curvature::kFull) return;
  INFO(variance << ", " << correlation << ", " << random << ", curvature "
                << static_cast<int>(curvature) << ", " << points << " points");
  Setting setting(curve(table, random, variance, correlation), table, curvature, points);
  setting.at.observation.variance = setting.variance.start();
  setting.at.observation.variance.tail(setting.variance.correlation_count()).setConstant(0.4);
  check_gradient(setting);
}

TEST_CASE("gradients of adaptive quadrature equal differences of its values") {
  const Table table = nested_stands(5, 4);
  const char* const variance = GENERATE("none", "power");
  const char* const random = GENERATE("a | plot", "a + b | plot");
  const int points = GENERATE(2, 5);
  INFO(variance << ", " << random << ", " << points << " points");
  Setting setting(curve(table, random, variance), table, Curvature::kFull, points);
  check_gradient(setting);
}

TEST_CASE("a model linear in its random effects has the likelihood of its dense covariance") {
  const Table table = nested_stands(6, 4);
  ModelSpecification model = specify_model("h ~ a + b*dbh", {"b ~ 1 + C"}, table);
  add_random_effects(model, "a | stand; a + b | plot", table);
  for (const Curvature curvature :
       {Curvature::kFull, Curvature::kExpected, Curvature::kFirstOrder}) {
    Setting setting(model, table, curvature);
    const NonlinearModel& bound = setting.model;
    NonlinearModel::Workspace workspace;
    VectorXd mean;
    MatrixXd jacobian;
    bound.evaluate(setting.at.observation.beta, mean, &jacobian, workspace);
    const double sigma2 = std::exp(2.0 * setting.at.observation.log_sigma);
    MatrixXd covariance = sigma2 * MatrixXd::Identity(mean.size(), mean.size());
    const MatrixXd of_plots = setting.at.factors.back() * setting.at.factors.back().transpose();
    const double of_stands = std::pow(setting.at.factors.front()(0, 0), 2);
    for (Index c = 0; c < bound.cluster_count(); ++c) {
      const Index first = bound.group_begin(bound.cluster_begin(c));
      const Index rows = bound.group_begin(bound.cluster_begin(c + 1)) - first;
      covariance.block(first, first, rows, rows).array() += of_stands;
      for (Index g = bound.cluster_begin(c); g < bound.cluster_begin(c + 1); ++g) {
        const Index begin = bound.group_begin(g);
        const Index size = bound.group_begin(g + 1) - begin;
        const MatrixXd z = jacobian.block(begin, 0, size, 2);
        covariance.block(begin, begin, size, size) += z * of_plots * z.transpose();
      }
    }
    const double expected = normal_minus_log_density(bound.response() - mean, covariance);
    CHECK(setting.value() == Approx(expected).epsilon(1e-12));
  }
}

TEST_CASE("many points of quadrature give the integral") {
  const Table table = nested_stands(3, 3);
  Setting exact(curve(table, "a | plot", "power"), table, Curvature::kFull, 60);
  // Simpson's rule over 12 standard deviations on each side, group by group.
  const NonlinearModel& model = exact.model;
  NonlinearModel::Workspace workspace;
  double expected = 0.0;
  for (Index g = 0; g < model.group_count(); ++g) {
    const Index begin = model.group_begin(g);
    const Index size = model.group_begin(g + 1) - begin;
    constexpr int kIntervals = 4000;
    constexpr double kReach = 12.0;
    double integral = 0.0;
    for (int k = 0; k <= kIntervals; ++k) {
      const double v = -kReach + 2.0 * kReach * k / kIntervals;
      VectorXd beta = exact.at.observation.beta;
      beta[0] += exact.at.factors.front()(0, 0) * v;
      VectorXd mean;
      model.evaluate(beta, mean, nullptr, workspace);
      const ResidualScale scale = exact.variance.scale(mean, exact.at.observation.variance, false);
      const Eigen::ArrayXd sd =
          std::exp(exact.at.observation.log_sigma) * scale.weight.segment(begin, size).rsqrt();
      const Eigen::ArrayXd error = (model.response() - mean).segment(begin, size).array() / sd;
      const double log_density =
          -0.5 * error.square().sum() - sd.log().sum() - 0.5 * v * v -
          0.5 * static_cast<double>(size + 1) * std::log(2.0 * std::numbers::pi);
      const double weight = k == 0 || k == kIntervals ? 1.0 : (k % 2 == 0 ? 2.0 : 4.0);
      integral += weight * std::exp(log_density);
    }
    expected -= std::log(integral * 2.0 * kReach / kIntervals / 3.0);
  }
  CHECK(exact.value() == Approx(expected).epsilon(1e-10));
  // Fifteen points are sufficient here; Laplace's method has its own error.
  Setting fifteen(curve(table, "a | plot", "power"), table, Curvature::kFull, 15);
  CHECK(fifteen.value() == Approx(expected).epsilon(1e-7));
}

TEST_CASE("quadrature is exact for polynomials under the normal distribution") {
  const QuadratureRule rule = gauss_hermite(5, 2);
  const auto expectation = [&](const std::function<double(double, double)>& f) {
    double sum = 0.0;
    for (Index k = 0; k < rule.weights.size(); ++k) {
      sum += rule.weights[k] * f(rule.nodes(0, k), rule.nodes(1, k));
    }
    return sum;
  };
  CHECK(expectation([](double, double) { return 1.0; }) == Approx(1.0).epsilon(1e-14));
  CHECK(expectation([](double x, double) { return std::pow(x, 8); }) ==
        Approx(105.0).epsilon(1e-13));
  CHECK(expectation([](double x, double y) { return x * x * std::pow(y, 4); }) ==
        Approx(3.0).epsilon(1e-13));
}

TEST_CASE("the value does not depend on the number of threads") {
  const Table table = nested_stands(60, 100);
  const ModelSpecification specification = curve(table, "a + b | plot", "power");
  const NonlinearModel model(specification, table, 8);
  const VarianceModel variance(specification.variance, VarianceData::of(model));
  Setting one(specification, table, Curvature::kFull);
  MarginalLikelihood several(model, variance, Curvature::kFull, 1);
  const MarginalValue a = one.likelihood.evaluate(one.at, true);
  const MarginalValue b = several.evaluate(one.at, true);
  CHECK(a.minus_log_likelihood == b.minus_log_likelihood);
  CHECK(a.by_beta == b.by_beta);
  CHECK(a.by_factors == b.by_factors);
}

TEST_CASE("modes follow the parameters to first order") {
  const Table table = nested_stands(6, 8);
  const char* const variance = GENERATE("none", "power", "power(fitted | species)");
  const char* const correlation = GENERATE("none", "car1(dbh)", "exponential(dbh; nugget)");
  const Curvature curvature =
      GENERATE(Curvature::kFull, Curvature::kExpected, Curvature::kFirstOrder);
  const char* const random = GENERATE("a + b | plot", "a | stand; a + b | plot");
  INFO(variance << ", " << correlation << ", " << random << ", curvature "
                << static_cast<int>(curvature));
  Setting setting(curve(table, random, variance, correlation), table, curvature);
  const NonlinearModel& model = setting.model;
  const auto sums = make_group_sums(model, setting.variance, curvature, {0, 1});
  const EffectLayout& layout = setting.likelihood.layout();
  const RandomPlaces& places = setting.likelihood.places();
  MarginalBlock block(model, layout, *sums, places, nullptr, 0, model.cluster_count());
  GroupSums::Workspace workspace;
  MatrixXd effects = MatrixXd::Zero(2, model.group_count());
  const auto search = [&](const MarginalPoint& at, bool with_gradient, VectorXd& modes) {
    sums->set_point(at.observation);
    RandomDesign design{.joint = SmallMatrix::Zero(2, layout.joint_count()),
                        .shared = layout.joint_count() - layout.count(layout.terms() - 1)};
    Index column = 0;
    for (std::size_t t = 0; t < layout.terms(); ++t) {
      add_placed(at.factors[t], places.rows[t], column, design.joint);
      column += layout.count(t);
    }
    block.value(at, design, modes, effects, workspace, with_gradient);
    return design;
  };
  VectorXd modes = VectorXd::Zero(layout.size());
  const RandomDesign design = search(setting.at, true, modes);
  block.keep(design);

  // All parameters change by a small relative amount.
  constexpr double kShare = 1e-5;
  MarginalPoint moved = setting.at;
  moved.observation.beta *= 1.0 + kShare;
  moved.observation.variance *= 1.0 - 2.0 * kShare;
  moved.observation.log_sigma += 3.0 * kShare;
  moved.factors.front() *= 1.0 - 3.0 * kShare;
  moved.factors.back() *= 1.0 + 4.0 * kShare;
  VectorXd exact = modes;
  const RandomDesign there = search(moved, false, exact);
  VectorXd followed = modes;
  block.follow(
      {.observation = {.beta = moved.observation.beta - setting.at.observation.beta,
                       .variance = moved.observation.variance - setting.at.observation.variance,
                       .log_sigma = 3.0 * kShare},
       .design = {.joint = there.joint - design.joint, .shared = there.shared}},
      followed);
  // The remainder is of second order, and modes are found to 1e-9.
  const double change = (exact - modes).norm();
  REQUIRE(change > 1e-6);
  CHECK((followed - exact).norm() < 1e-3 * change + 2e-8);
}
