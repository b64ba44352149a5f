// SPDX-License-Identifier: MIT
#include "silvafit/fit/calibration.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "prediction/joint_posterior.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "test_support/nested_trees.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using silvafit::Random;
using silvafit::data::Table;
using silvafit::data::TextColumn;
using namespace silvafit::fit;
using Catch::Matchers::Contains;
using silvafit::kNaN;

namespace {

const char* const kCurve = "h ~ 1.3 + a*(1 - exp(-b*dbh))";

struct Design {
  int stands = 1;
  int plots = 14;  ///< in each stand
  int trees = 9;
  std::uint64_t seed = 4;
  double residual = 0.25;  ///< standard deviation where the height is 1; grows by its square root
};

/// Trees of a height curve whose asymptote and rate differ by plot, and asymptote also by stand.
Table trees_of(const Design& design) {
  Random random(design.seed);
  std::vector<NestedTree> trees;
  for (int s = 0; s < design.stands; ++s) {
    const double of_stand = random.normal(0.0, 2.5);
    for (int i = 0; i < design.plots; ++i) {
      const double limit = 26.0 + of_stand + random.normal(0.0, 2.5);
      const double rate = 0.06 + random.normal(0.0, 0.008);
      for (int j = 0; j < design.trees; ++j) {
        NestedTree tree{.stand = fmt::format("S{}", s), .plot = fmt::format("P{}", i)};
        tree.species = j % 2 == 0 ? "fir" : "oak";
        tree.dbh_cm = random.uniform(5.0, 45.0);
        tree.crowding = random.uniform();
        const double rate_of_tree = rate - 0.01 * tree.crowding;
        const double mean = 1.3 + limit * (1.0 - std::exp(-rate_of_tree * tree.dbh_cm));
        tree.h_m = mean + random.normal(0.0, design.residual * std::sqrt(mean));
        trees.push_back(tree);
      }
    }
  }
  return table_of(trees);
}

struct Case {
  std::string random = "a + b | plot";
  std::string variance = "none";
  Method method = Method::kLindstromBates;
};

FittedModel fitted(const Table& table, const Case& of) {
  ModelSpecification model = specify_model(kCurve, {"b ~ 1 + C"}, table);
  add_random_effects(model, of.random, table);
  model.variance = parse_variance_function(of.variance);
  FittedModel fit = fit_model(model, table, {.method = of.method, .quadrature_points = 5}).fit;
  INFO(fit.convergence.verdict());
  REQUIRE(fit.convergence.converged());
  return fit;
}

/// The largest difference of two sets of effects, in standard deviations of each effect.
double distance(const MatrixXd& effects, const MatrixXd& others, const MatrixXd& covariance) {
  const VectorXd sd = covariance.diagonal().cwiseSqrt();
  return (sd.cwiseInverse().asDiagonal() * (effects - others)).cwiseAbs().maxCoeff();
}

/// The effects of calibration in the order of the fit's groups.
MatrixXd in_order_of_fit(const Calibration& calibration, Index groups) {
  MatrixXd result(calibration.random.back().effects.rows(), groups);
  for (std::size_t g = 0; g < calibration.random.back().labels.size(); ++g) {
    result.col(calibration.random.back().fitted_group[g]) =
        calibration.random.back().effects.col(static_cast<Index>(g));
  }
  return result;
}

}  // namespace

TEST_CASE("calibration on a fit's own trees returns its own random effects") {
  const Table table = trees_of({});
  // Effects at given parameters are found to 1e-9 standard deviations by both.
  for (const Method method : {Method::kLindstromBates,
                              Method::kFirstOrder,
                              Method::kInteraction,
                              Method::kLaplace,
                              Method::kQuadrature}) {
    for (const char* variance :
         {"none", "power", "exponential", "power(dbh)", "stratum(species) * power"}) {
      INFO(silvafit::word_of(method) << " " << variance);
      const FittedModel fit = fitted(table, {.variance = variance, .method = method});
      const Calibration calibration = calibrate(fit, table, {.seen_groups = SeenGroups::kNew});
      CHECK(distance(in_order_of_fit(calibration, fit.random.back().effects.cols()),
                     fit.random.back().effects,
                     fit.random.back().covariance) < 1e-8);
      // The stored values of the fit equal those of the calibration.
      CHECK(calibration.random.back().uncertainty.covariances.isApprox(
          fit.random.back().uncertainty.covariances, 1e-7));
      CHECK(calibration.random.back().uncertainty.sensitivities.isApprox(
          fit.random.back().uncertainty.sensitivities, 1e-7));
    }
  }
}

namespace {

/// The negative log of the joint density of a plot's trees and its effects, written out; of lb the
/// penalized sum of squares with the weights of the effects `held`.
class WrittenOut {
 public:
  WrittenOut(const FittedModel& fit, const Table& table, const std::string& plot)
      : fit_(fit),
        dbh_(table.numbers("dbh")),
        crowding_(table.numbers("C")),
        h_(table.numbers("h")),
        precision_(fit.random.back().covariance.inverse()) {
    const TextColumn labels = table.labels("plot");
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (labels[row] == plot) rows_.push_back(row);
    }
  }

  double operator()(const VectorXd& effects, const VectorXd& held) const {
    double sum = 0.5 * effects.dot(precision_ * effects);
    for (const std::size_t row : rows_) {
      const double residual = h_[row] - mean(effects, row);
      const double sd = sd_of(scale_from(effects, held), row);
      sum += 0.5 * residual * residual / (sd * sd);
      if (fit_.method != Method::kLindstromBates) sum += std::log(sd);
    }
    return sum;
  }

 private:
  double mean(const VectorXd& effects, std::size_t row) const {
    const VectorXd& beta = fit_.estimate;
    const double rate = beta[1] + effects[1] + beta[2] * crowding_[row];
    return 1.3 + (beta[0] + effects[0]) * (1.0 - std::exp(-rate * dbh_[row]));
  }
  VectorXd scale_from(const VectorXd& effects, const VectorXd& held) const {
    if (fit_.method == Method::kLindstromBates) return held;
    return fit_.method == Method::kFirstOrder ? VectorXd::Zero(2) : effects;
  }
  double sd_of(const VectorXd& effects, std::size_t row) const {
    return fit_.sigma * std::pow(mean(effects, row), fit_.variance.delta());
  }

  const FittedModel& fit_;
  std::span<const double> dbh_;
  std::span<const double> crowding_;
  std::span<const double> h_;
  MatrixXd precision_;
  std::vector<std::size_t> rows_;
};

}  // namespace

TEST_CASE("at the calibrated effects the gradient of the density vanishes") {
  const Table table = trees_of({.plots = 6});
  for (const Method method :
       {Method::kLindstromBates, Method::kFirstOrder, Method::kInteraction, Method::kLaplace}) {
    INFO(silvafit::word_of(method));
    FittedModel fit = fitted(table, {.variance = "power", .method = method});
    // That of the fit may be singular.
    fit.random.back().covariance = Eigen::Matrix2d{{6.0, 0.004}, {0.004, 6e-5}};
    const Calibration calibration = calibrate(fit, table, {.seen_groups = SeenGroups::kNew});
    const CalibratedEffects& term = calibration.random.back();
    const VectorXd sd = fit.random.back().sd();
    for (std::size_t g = 0; g < term.labels.size(); ++g) {
      const WrittenOut objective(fit, table, term.labels[g]);
      const VectorXd effects = term.effects.col(static_cast<Index>(g));
      for (Index k = 0; k < 2; ++k) {
        // Slope by standard deviations: differences over 1e-4 of one have an error of about 1e-8.
        const VectorXd step = 1e-4 * sd[k] * VectorXd::Unit(2, k);
        const double slope =
            (objective(effects + step, effects) - objective(effects - step, effects)) / 2e-4;
        CHECK(std::abs(slope) < 1e-5);
      }
    }
  }
}

TEST_CASE("calibration returns a nested fit's own random effects of both groupings") {
  const Table table = trees_of({.stands = 9, .plots = 4});
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    INFO(silvafit::word_of(method));
    const FittedModel fit = fitted(
        table, {.random = "a | stand; a + b | stand/plot", .variance = "power", .method = method});
    const Calibration calibration = calibrate(fit, table, {.seen_groups = SeenGroups::kNew});
    CHECK(calibration.random.front().labels == fit.random.front().labels);
    // The alternation of lb ends at a decrement of 1e-12: a millionth of a standard error.
    const double tolerance = method == Method::kLindstromBates ? 1e-6 : 1e-8;
    CHECK(distance(in_order_of_fit(calibration, fit.random.back().effects.cols()),
                   fit.random.back().effects,
                   fit.random.back().covariance) < tolerance);
    CHECK(distance(calibration.random.front().effects,
                   fit.random.front().effects,
                   fit.random.front().covariance) < tolerance);
  }
}

namespace {

/// A line with random intercept and slope by plot and a random intercept by stand.
FittedModel line(bool is_nested) {
  FittedModel fit({.formula = silvafit::data::parse_formula("y ~ a + b*x")});
  fit.specification.parameters = {parse_parameter_model("a ~ 1"), parse_parameter_model("b ~ 1")};
  fit.specification.random =
      parse_random_effects(is_nested ? "a | stand; a + b | plot" : "a + b | plot");
  fit.method = Method::kLaplace;
  fit.coefficient_names = {"a", "b"};
  fit.estimate = Eigen::Vector2d(2.0, 0.5);
  fit.covariance = Eigen::Matrix2d{{0.04, -0.003}, {-0.003, 0.002}};
  if (is_nested) {
    fit.random.push_back(
        {.names = {"a"}, .covariance = MatrixXd::Constant(1, 1, 0.5), .effects = MatrixXd(1, 0)});
  }
  fit.random.push_back({.names = {"a", "b"},
                        .covariance = Eigen::Matrix2d{{1.0, -0.1}, {-0.1, 0.05}},
                        .effects = MatrixXd(2, 0)});
  fit.sigma = 0.4;
  return fit;
}

std::vector<std::vector<std::string>> labels_of(const Calibration& calibration) {
  std::vector<std::vector<std::string>> result;
  for (const auto& term : calibration.random) result.push_back(term.labels);
  return result;
}

/// `stands` of three plots with 1, 2 and 4 trees each.
Table line_data(int stands) {
  Random random(11);
  TextColumn stand;
  TextColumn plot;
  std::vector<double> x;
  std::vector<double> y;
  for (int s = 0; s < stands; ++s) {
    for (const int trees : {1, 2, 4}) {
      for (int j = 0; j < trees; ++j) {
        stand.append(fmt::format("S{}", s));
        plot.append(fmt::format("P{}", trees));
        x.push_back(random.uniform(-2.0, 3.0));
        y.push_back(random.normal(2.0, 1.5));
      }
    }
  }
  Table table;
  table.set("stand", stand);
  table.set("plot", plot);
  table.set("x", x);
  table.set("y", y);
  return table;
}

/// The matrices of one stand of line_data, written out: effects are (stand, plot 1, plot 2, plot
/// 3).
struct DenseLine {
  MatrixXd x = MatrixXd::Ones(7, 2);
  MatrixXd z = MatrixXd::Zero(7, 7);
  MatrixXd psi = MatrixXd::Zero(7, 7);
  VectorXd residual;
  MatrixXd inverse;  ///< of V

  DenseLine(const FittedModel& fit, const Table& table) {
    x.col(1) = Eigen::Map<const VectorXd>(table.numbers("x").data(), 7);
    residual = Eigen::Map<const VectorXd>(table.numbers("y").data(), 7) - x * fit.estimate;
    z.col(0).setOnes();
    psi(0, 0) = fit.random.size() < 2 ? 0.0 : fit.random.front().covariance(0, 0);
    Index row = 0;
    for (Index plot = 0; plot < 3; ++plot) {
      const Index trees = plot == 2 ? 4 : plot + 1;
      z.block(row, 1 + 2 * plot, trees, 2) = x.middleRows(row, trees);
      psi.block(1 + 2 * plot, 1 + 2 * plot, 2, 2) = fit.random.back().covariance;
      row += trees;
    }
    const MatrixXd v = z * psi * z.transpose() + fit.sigma * fit.sigma * MatrixXd::Identity(7, 7);
    inverse = v.inverse();
  }
};

}  // namespace

TEST_CASE("in a linear model calibration is the best linear unbiased prediction") {
  const bool is_nested = GENERATE(false, true);
  const Method method = GENERATE(Method::kLaplace, Method::kLindstromBates);
  FittedModel fit = line(is_nested);
  fit.method = method;
  const Table table = line_data(1);
  const DenseLine dense(fit, table);
  const MatrixXd gain = dense.psi * dense.z.transpose() * dense.inverse;
  const VectorXd blup = gain * dense.residual;
  const MatrixXd covariance = dense.psi - gain * dense.z * dense.psi;
  const MatrixXd slope = -gain * dense.x;
  const Calibration calibration = calibrate(fit, table);
  // Closed forms of 7 x 7 matrices, inverted in double precision.
  constexpr double kRounding = 1e-11;
  for (Index plot = 0; plot < 3; ++plot) {
    const Index k = 1 + 2 * plot;
    CHECK(calibration.random.back().effects.col(plot).isApprox(blup.segment(k, 2), kRounding));
    CHECK(calibration.random.back().uncertainty.covariance(plot, 2).isApprox(
        covariance.block(k, k, 2, 2), kRounding));
    CHECK(calibration.random.back()
              .uncertainty.sensitivity(plot, 2, 2)
              .isApprox(slope.middleRows(k, 2), kRounding));
    if (!is_nested) continue;
    const MatrixXd between = JointPosterior(fit, calibration.cells, labels_of(calibration))
                                 .between_terms({{0, plot}})[0];
    CHECK(between.bottomLeftCorner(2, 1).isApprox(covariance.block(k, 0, 2, 1), kRounding));
  }
  CHECK(calibration.random.back().measured == std::vector<Index>{1, 2, 4});
  if (!is_nested) return;
  CHECK(calibration.random.front().effects(0, 0) == Approx(blup[0]).epsilon(kRounding));
  CHECK(calibration.random.front().uncertainty.covariances(0, 0) ==
        Approx(covariance(0, 0)).epsilon(kRounding));
  CHECK(calibration.random.front().uncertainty.sensitivity(0, 1, 2).isApprox(slope.topRows(1),
                                                                             kRounding));
}

TEST_CASE("conditional covariance and sensitivity are the inverse of Henderson's matrix") {
  const FittedModel fit = line(true);
  const Table table = line_data(1);
  const DenseLine dense(fit, table);
  // Henderson's coefficient matrix of (beta, u, v) and, for the variance of beta-hat, these data.
  const double precision = 1.0 / (fit.sigma * fit.sigma);
  MatrixXd henderson(9, 9);
  henderson << precision * dense.x.transpose() * dense.x, precision * dense.x.transpose() * dense.z,
      precision * dense.z.transpose() * dense.x,
      precision * dense.z.transpose() * dense.z + dense.psi.inverse();
  const MatrixXd inverse = henderson.inverse();
  const MatrixXd of_beta = (dense.x.transpose() * dense.inverse * dense.x).inverse();
  const Calibration calibration = calibrate(fit, table);
  constexpr double kRounding = 1e-10;
  CHECK(inverse.topLeftCorner(2, 2).isApprox(of_beta, kRounding));
  for (Index plot = 0; plot < 3; ++plot) {
    const Index k = 3 + 2 * plot;
    const MatrixXd s = calibration.random.back().uncertainty.sensitivity(plot, 2, 2);
    CHECK(inverse.block(k, 0, 2, 2).isApprox(s * of_beta, kRounding));
    CHECK(inverse.block(k, k, 2, 2)
              .isApprox(calibration.random.back().uncertainty.covariance(plot, 2) +
                            s * of_beta * s.transpose(),
                        kRounding));
  }
}

TEST_CASE("the sensitivity is the derivative of random effects by the coefficients") {
  const Table table = trees_of({.stands = 5, .plots = 4, .trees = 4});
  const Method method = GENERATE(
      Method::kLindstromBates, Method::kFirstOrder, Method::kInteraction, Method::kLaplace);
  INFO(silvafit::word_of(method));
  FittedModel fit = fitted(trees_of({.stands = 8, .plots = 4}),
                           {.random = "a | stand; a + b | stand/plot", .variance = "power"});
  fit.method = method;
  const CalibrationOptions options{.seen_groups = SeenGroups::kNew};
  const Calibration here = calibrate(fit, table, options);
  for (Index j = 0; j < 3; ++j) {
    const double step = 1e-4 * std::sqrt(fit.covariance(j, j));
    FittedModel moved = fit;
    moved.estimate[j] += step;
    const Calibration up = calibrate(moved, table, options);
    moved.estimate[j] -= 2.0 * step;
    const Calibration down = calibrate(moved, table, options);
    const MatrixXd slope = (up.random.back().effects - down.random.back().effects) / (2.0 * step);
    const MatrixXd stand_slope =
        (up.random.front().effects - down.random.front().effects) / (2.0 * step);
    // Differences of effects that are exact to 1e-9 standard deviations, over 2e-4 of them.
    for (Index g = 0; g < slope.cols(); ++g) {
      const VectorXd expected = here.random.back().uncertainty.sensitivity(g, 2, 3).col(j);
      CHECK((slope.col(g) - expected).cwiseAbs().maxCoeff() <
            1e-4 * (1e-3 + expected.cwiseAbs().maxCoeff()));
    }
    for (Index c = 0; c < stand_slope.cols(); ++c) {
      const double expected = here.random.front().uncertainty.sensitivity(c, 1, 3)(0, j);
      CHECK(stand_slope(0, c) == Approx(expected).epsilon(1e-4).margin(1e-6));
    }
  }
}

TEST_CASE("a singular covariance of the random effects is an ordinary point") {
  FittedModel fit = line(false);
  fit.random.back().covariance = Eigen::Matrix2d{{1.0, -0.2}, {-0.2, 0.04}};
  const Table table = line_data(1);
  const DenseLine dense(fit, table);
  const VectorXd blup = dense.psi * dense.z.transpose() * dense.inverse * dense.residual;
  const Calibration calibration = calibrate(fit, table);
  for (Index plot = 0; plot < 3; ++plot) {
    CHECK(
        calibration.random.back().effects.col(plot).isApprox(blup.segment(1 + 2 * plot, 2), 1e-7));
    CHECK(calibration.random.back().effects(1, plot) ==
          Approx(-0.2 * calibration.random.back().effects(0, plot)));
  }
  fit.random.back().covariance.setZero();
  CHECK(calibrate(fit, table).random.back().effects.isZero(0.0));
}

namespace {

/// A fit that has seen the groups of a table.
FittedModel that_has_seen(FittedModel fit, const Table& table) {
  const Calibration calibration = calibrate(fit, table);
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    fit.random[k].labels = calibration.random[k].labels;
    fit.random[k].effects = calibration.random[k].effects;
    fit.random[k].uncertainty = calibration.random[k].uncertainty;
  }
  fit.cells = calibration.cells;
  return fit;
}

}  // namespace

TEST_CASE("calibration with earlier and new trees equals that with all trees together") {
  const bool is_nested = GENERATE(false, true);
  const FittedModel unseen = line(is_nested);
  const Table table = line_data(2);
  // Earlier: trees 0 2 4 6 8 ...; the first plot of the second stand has only a new tree.
  std::vector<std::size_t> earlier;
  std::vector<std::size_t> later;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    (row % 2 == 0 ? earlier : later).push_back(row);
  }
  const FittedModel seen = that_has_seen(unseen, table.select(earlier));
  // Rows of earlier trees stay in the table, without their measurement, so that all plots are
  // there.
  std::vector<double> y(table.numbers("y").begin(), table.numbers("y").end());
  for (const std::size_t row : earlier) y[row] = kNaN;
  Table new_trees = table;
  new_trees.set("y", y);
  const Calibration both = calibrate(seen, new_trees, {.seen_groups = SeenGroups::kCombined});
  const Calibration all = calibrate(unseen, table);
  // In a linear model the two are the same.
  constexpr double kRounding = 1e-9;
  CHECK(both.random.back().labels == all.random.back().labels);
  CHECK(both.random.back().effects.isApprox(all.random.back().effects, kRounding));
  CHECK(both.random.back().uncertainty.covariances.isApprox(
      all.random.back().uncertainty.covariances, kRounding));
  CHECK(both.random.back().uncertainty.sensitivities.isApprox(
      all.random.back().uncertainty.sensitivities, kRounding));
  CHECK(both.random.front().effects.isApprox(all.random.front().effects, kRounding));
  CHECK(both.random.front().uncertainty.sensitivities.isApprox(
      all.random.front().uncertainty.sensitivities, kRounding));
  if (!is_nested) return;
  const std::vector<std::vector<Index>> groups{{0, 1}, {1, 4}};
  const auto between = JointPosterior(seen, both.cells, labels_of(both)).between_terms(groups);
  const auto of_all = JointPosterior(unseen, all.cells, labels_of(all)).between_terms(groups);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    CHECK(between[k].isApprox(of_all[k], kRounding));
  }
}

TEST_CASE("by default a known group keeps the fit's random effects, and a new one is calibrated") {
  const Table table = line_data(2);
  const FittedModel seen =
      that_has_seen(line(true), table.select(std::vector<std::size_t>{0, 1, 2}));
  const Calibration calibration = calibrate(seen, table);
  REQUIRE(calibration.random.back().labels ==
          std::vector<std::string>{"S0/P1", "S0/P2", "S0/P4", "S1/P1", "S1/P2", "S1/P4"});
  CHECK(calibration.random.back().fitted_group == std::vector<Index>{0, 1, -1, -1, -1, -1});
  CHECK(calibration.random.front().fitted_group == std::vector<Index>{0, -1});
  CHECK(calibration.random.back().measured == std::vector<Index>{0, 0, 4, 1, 2, 4});
  CHECK_FALSE(calibration.is_used[0]);
  CHECK(calibration.is_used[3]);
  // Of the first stand, three trees were fitted to and four are new: together all of its trees.
  const Calibration all = calibrate(line(true), table);
  CHECK(calibration.random.back().effects.col(2).isApprox(all.random.back().effects.col(2), 1e-9));
  CHECK(calibration.random.back().effects.rightCols(3).isApprox(
      all.random.back().effects.rightCols(3), 1e-12));
}

TEST_CASE("a group without measured trees has the prior of any group") {
  FittedModel fit = line(false);
  Table table = line_data(1);
  std::vector<double> y(table.numbers("y").begin(), table.numbers("y").end());
  y[1] = y[2] = kNaN;
  table.set("y", y);
  const Calibration calibration = calibrate(fit, table);
  CHECK(calibration.random.back().measured == std::vector<Index>{1, 0, 4});
  CHECK(calibration.random.back().effects.col(1).isZero(0.0));
  CHECK(calibration.random.back().uncertainty.covariance(1, 2) == fit.random.back().covariance);
  CHECK(calibration.random.back().uncertainty.sensitivities.col(1).isZero(0.0));
  // A table without the response is one without measured trees.
  Table unmeasured;
  unmeasured.set("plot", table.text("plot"));
  unmeasured.set("x", std::vector<double>(table.numbers("x").begin(), table.numbers("x").end()));
  CHECK(calibrate(fit, unmeasured).random.back().effects.isZero(0.0));
}

TEST_CASE("calibration does not depend on the number of threads") {
  const Table table = trees_of({.stands = 40, .plots = 30, .trees = 8});
  const FittedModel fit = fitted(trees_of({}), {.variance = "power"});
  const Calibration one = calibrate(fit, table, {.threads = 1});
  const Calibration two = calibrate(fit, table, {.threads = 2});
  CHECK(one.random.back().effects == two.random.back().effects);
  CHECK(one.random.back().uncertainty.covariances == two.random.back().uncertainty.covariances);
  CHECK(one.random.back().effects.allFinite());
}

TEST_CASE("impossible calibrations are refused") {
  FittedModel fit = line(false);
  Table table = line_data(1);
  Table infinite = table;
  infinite.set("y", std::vector<double>(table.rows(), silvafit::kInfinity));
  CHECK_THROWS_WITH(calibrate(fit, infinite), Contains("infinite"));
  CHECK_THROWS_WITH(calibrate(fit, table, {.seen_groups = SeenGroups::kCombined}),
                    Contains("fit the model again"));
  fit.random.clear();
  CHECK_THROWS_WITH(calibrate(fit, table), Contains("no random effects"));
}

TEST_CASE("the file of a fit has the uncertainty of its random effects") {
  const FittedModel fit = fitted(trees_of({.stands = 6, .plots = 4}),
                                 {.random = "a | stand; a + b | stand/plot", .variance = "power"});
  REQUIRE(fit.random.back().uncertainty.is_known());
  const FittedModel read = from_json(to_json(fit), "fit.json");
  CHECK(read.random.back().uncertainty.covariances == fit.random.back().uncertainty.covariances);
  CHECK(read.random.back().uncertainty.sensitivities ==
        fit.random.back().uncertainty.sensitivities);
  CHECK(read.cells.groups == fit.cells.groups);
  CHECK(read.cells.curvatures == fit.cells.curvatures);
  CHECK(read.random.front().uncertainty.covariances == fit.random.front().uncertainty.covariances);
  CHECK(read.random.front().uncertainty.sensitivities ==
        fit.random.front().uncertainty.sensitivities);
}
