// SPDX-License-Identifier: MIT
#include "silvafit/fit/mixed_effects.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "model/relative_factor.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using silvafit::Random;
using silvafit::data::Table;
using silvafit::data::TextColumn;
using namespace silvafit::fit;

namespace {

constexpr int kGroups = 8;
constexpr int kRows = 6;

Table one_way(double between, double within) {
  Random random(5);
  Table table;
  TextColumn plot;
  std::vector<double> y;
  for (int i = 0; i < kGroups; ++i) {
    const double effect = random.normal(0.0, between);
    for (int j = 0; j < kRows; ++j) {
      plot.append(std::to_string(i));
      y.push_back(10.0 + effect + random.normal(0.0, within));
    }
  }
  table.set("plot", plot);
  table.set("y", y);
  return table;
}

/// Balanced one-way layout: its maximum-likelihood estimates are known in closed form.
struct OneWay {
  double mean = 0.0;
  double between = 0.0;  ///< sum of squares between groups
  double within = 0.0;   ///< sum of squares within groups

  explicit OneWay(const Table& table) {
    const auto y = table.numbers("y");
    for (const double value : y) mean += value / static_cast<double>(y.size());
    for (int i = 0; i < kGroups; ++i) {
      double group = 0.0;
      for (int j = 0; j < kRows; ++j) group += y[i * kRows + j] / kRows;
      between += kRows * (group - mean) * (group - mean);
      for (int j = 0; j < kRows; ++j) within += std::pow(y[i * kRows + j] - group, 2);
    }
  }
};

ModelSpecification one_way_model(const Table& table) {
  ModelSpecification model = specify_model("y ~ mu", {}, table);
  model.random = {{.coefficients = {"mu"}, .group = "plot"}};
  return model;
}

/// Trees of a growth curve whose asymptote differs by plot.
Table scaled_curves(double scale) {
  Random random(77);
  Table table;
  TextColumn plot;
  std::vector<double> dbh;
  std::vector<double> h;
  for (int i = 0; i < 15; ++i) {
    const double limit = 25.0 + random.normal(0.0, 3.0);
    for (int j = 0; j < 20; ++j) {
      plot.append(std::to_string(i));
      dbh.push_back(random.uniform(5.0, 45.0));
      const double mean = limit * (1.0 - std::exp(-0.07 * dbh.back()));
      h.push_back(scale * (mean + random.normal(0.0, 0.05 * mean)));
    }
  }
  table.set("plot", plot);
  table.set("dbh", dbh);
  table.set("h", h);
  return table;
}

MixedEffectsFit fit_curves(const Table& table, double scale, const char* variance) {
  ModelSpecification model = specify_model("h ~ a*(1 - exp(-b*dbh))", {}, table);
  model.random = {{.coefficients = {"a"}, .group = "plot"}};
  model.variance = parse_variance_function(variance);
  return fit_lindstrom_bates(NonlinearModel(model, table), Eigen::Vector2d(20.0 * scale, 0.1));
}

}  // namespace

TEST_CASE("a balanced one-way layout has the closed-form solution") {
  const Table table = one_way(2.0, 1.0);
  const OneWay sums(table);
  const double sigma2 = sums.within / (kGroups * (kRows - 1));
  const double psi = (sums.between / kGroups - sigma2) / kRows;
  const MixedEffectsFit fit =
      fit_lindstrom_bates(NonlinearModel(one_way_model(table), table), VectorXd::Constant(1, 9.0));
  REQUIRE(fit.convergence.converged());
  CHECK(!fit.convergence.has_boundary());
  // Converged means within 1e-6 standard errors.
  CHECK(fit.estimate[0] == Approx(sums.mean).epsilon(1e-12));
  CHECK(fit.sigma * fit.sigma == Approx(sigma2).epsilon(1e-6));
  CHECK(fit.random.back().covariance(0, 0) == Approx(psi).epsilon(1e-6));
  const double n = kGroups * kRows;
  const double log_likelihood =
      -0.5 * (n * std::log(2.0 * std::numbers::pi) + kGroups * (kRows - 1) * std::log(sigma2) +
              kGroups * std::log(sigma2 + kRows * psi) + n);
  CHECK(fit.log_likelihood == Approx(log_likelihood).epsilon(1e-12));
  CHECK(fit.parameter_count == 3);
}

namespace {

/// Balanced stands with plots with trees: estimates are known in closed form.
struct NestedLayout {
  static constexpr int kStands = 6;
  static constexpr int kPlots = 4;
  static constexpr int kTrees = 5;
  Table table;
  double mean = 0.0;
  double between_stands = 0.0;  ///< sums of squares
  double between_plots = 0.0;
  double within = 0.0;

  NestedLayout() {
    Random random(9);
    TextColumn stand;
    TextColumn plot;
    std::vector<double> y;
    for (int i = 0; i < kStands; ++i) {
      const double of_stand = random.normal(0.0, 3.0);
      for (int j = 0; j < kPlots; ++j) {
        const double of_plot = random.normal(0.0, 2.0);
        for (int k = 0; k < kTrees; ++k) {
          stand.append(std::to_string(i));
          plot.append(std::to_string(j));  // the same names in every stand
          y.push_back(20.0 + of_stand + of_plot + random.normal());
        }
      }
    }
    const Eigen::Map<const Eigen::ArrayXd> all(y.data(), static_cast<Index>(y.size()));
    mean = all.mean();
    for (Index i = 0; i < kStands; ++i) {
      const Eigen::ArrayXd of_stand = all.segment(i * kPlots * kTrees, kPlots * kTrees);
      between_stands += kPlots * kTrees * std::pow(of_stand.mean() - mean, 2);
      for (Index j = 0; j < kPlots; ++j) {
        const Eigen::ArrayXd of_plot = of_stand.segment(j * kTrees, kTrees);
        between_plots += kTrees * std::pow(of_plot.mean() - of_stand.mean(), 2);
        within += (of_plot - of_plot.mean()).square().sum();
      }
    }
    table.set("stand", stand);
    table.set("plot", plot);
    table.set("y", y);
  }
};

}  // namespace

TEST_CASE("a balanced nested layout has the closed-form solution") {
  const NestedLayout layout;
  ModelSpecification specification = specify_model("y ~ mu", {}, layout.table);
  add_random_effects(specification, "mu | stand/plot", layout.table);
  const NonlinearModel model(specification, layout.table);
  constexpr double a = NestedLayout::kStands;
  constexpr double b = NestedLayout::kPlots;
  constexpr double n = NestedLayout::kTrees;
  constexpr double kObservations = a * b * n;
  const double within = layout.within / (a * b * (n - 1));
  const double plots = layout.between_plots / (a * (b - 1));
  for (const bool reml : {false, true}) {
    const double stands = layout.between_stands / (reml ? a - 1 : a);
    const MixedEffectsFit fit =
        fit_lindstrom_bates(model, VectorXd::Constant(1, 15.0), {.reml = reml});
    INFO(fit.convergence.verdict());
    REQUIRE(fit.convergence.converged());
    // Converged means within 1e-6 standard errors.
    CHECK(fit.estimate[0] == Approx(layout.mean).epsilon(1e-12));
    CHECK(fit.sigma == Approx(std::sqrt(within)).epsilon(1e-6));
    CHECK(fit.random.back().covariance(0, 0) == Approx((plots - within) / n).epsilon(1e-5));
    CHECK(fit.random.front().covariance(0, 0) == Approx((stands - plots) / (b * n)).epsilon(1e-5));
    const double freedom = kObservations - (reml ? 1.0 : 0.0);
    const double log_likelihood =
        -0.5 * (freedom * (std::log(2.0 * std::numbers::pi) + 1.0) +
                a * b * (n - 1) * std::log(within) + a * (b - 1) * std::log(plots) +
                (reml ? a - 1 : a) * std::log(stands) + (reml ? std::log(kObservations) : 0.0));
    CHECK(fit.log_likelihood == Approx(log_likelihood).epsilon(1e-12));
    // nlme's factor N / (N - p) for maximum likelihood; restricted likelihood needs none.
    const double variance =
        stands / kObservations * (reml ? 1.0 : kObservations / (kObservations - 1.0));
    CHECK(fit.standard_errors()[0] == Approx(std::sqrt(variance)).epsilon(1e-6));
    CHECK(fit.parameter_count == 4);
    CHECK(fit.random.front().names == std::vector<std::string>{"mu"});
    CHECK(fit.random.front().labels.size() == 6);
    CHECK(fit.random.back().effects.cols() == 24);
    // The trees' fitted values have both effects.
    CHECK(fit.fitted_conditional[0] == Approx(fit.estimate[0] + fit.random.front().effects(0, 0) +
                                              fit.random.back().effects(0, 0))
                                           .epsilon(1e-12));
  }
}

TEST_CASE("a boundary of the coarser grouping is named with the grouping") {
  NestedLayout layout;
  // The variance between stands is smaller than expected by chance.
  std::vector<double> y(layout.table.numbers("y").begin(), layout.table.numbers("y").end());
  constexpr int kSize = NestedLayout::kPlots * NestedLayout::kTrees;
  for (int i = 0; i < NestedLayout::kStands; ++i) {
    double mean = 0.0;
    for (int k = 0; k < kSize; ++k) mean += y[i * kSize + k] / kSize;
    for (int k = 0; k < kSize; ++k) y[i * kSize + k] -= mean;
  }
  layout.table.set("y", y);
  ModelSpecification specification = specify_model("y ~ mu", {}, layout.table);
  add_random_effects(specification, "mu | stand/plot", layout.table);
  const MixedEffectsFit fit =
      fit_lindstrom_bates(NonlinearModel(specification, layout.table), VectorXd::Constant(1, 0.1));
  CHECK(fit.convergence.converged());
  CHECK(fit.convergence.boundary() == std::vector<std::string>{"sd(mu | stand) = 0"});
}

TEST_CASE("restricted likelihood of weighted regression has the closed form") {
  Random random(21);
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 40; ++i) {
    x.push_back(random.uniform(1.0, 9.0));
    y.push_back(2.0 + 3.0 * x.back() + random.normal(0.0, std::sqrt(x.back())));
  }
  Table table;
  table.set("x", x);
  table.set("y", y);
  ModelSpecification specification = specify_model("y ~ a + b*x", {}, table);
  specification.variance = parse_variance_function("power(x, delta = 0.5)");
  const MixedEffectsFit fit = fit_lindstrom_bates(
      NonlinearModel(specification, table), Eigen::Vector2d(1.0, 1.0), {.reml = true});
  REQUIRE(fit.convergence.converged());
  // y / sqrt(x) is regressed on 1 / sqrt(x) and sqrt(x).
  MatrixXd design(40, 2);
  VectorXd response(40);
  double sum_log = 0.0;
  for (Index i = 0; i < 40; ++i) {
    const double root = std::sqrt(x[static_cast<std::size_t>(i)]);
    design.row(i) << 1.0 / root, root;
    response[i] = y[static_cast<std::size_t>(i)] / root;
    sum_log += std::log(root);
  }
  const MatrixXd information = design.transpose() * design;
  const VectorXd beta = information.inverse() * design.transpose() * response;
  const double sigma2 = (response - design * beta).squaredNorm() / 38.0;
  CHECK((fit.estimate - beta).norm() < 1e-9);
  CHECK(fit.sigma == Approx(std::sqrt(sigma2)).epsilon(1e-9));
  CHECK(fit.log_likelihood == Approx(-19.0 * (std::log(2.0 * std::numbers::pi * sigma2) + 1.0) -
                                     sum_log - 0.5 * std::log(information.determinant()))
                                  .epsilon(1e-10));
  CHECK(fit.standard_errors()[1] ==
        Approx(std::sqrt(sigma2 * information.inverse()(1, 1))).epsilon(1e-8));
}

TEST_CASE("a variance estimate of zero is found and named") {
  // Less variance between groups than by chance: the closed form is negative, the maximum at zero.
  Table table = one_way(0.0, 1.0);
  std::vector<double> y(table.numbers("y").begin(), table.numbers("y").end());
  for (int i = 0; i < kGroups; ++i) {
    double group = 0.0;
    for (int j = 0; j < kRows; ++j) group += y[i * kRows + j] / kRows;
    for (int j = 0; j < kRows; ++j) y[i * kRows + j] -= group;
  }
  table.set("y", y);
  const MixedEffectsFit fit =
      fit_lindstrom_bates(NonlinearModel(one_way_model(table), table), VectorXd::Constant(1, 0.1));
  CHECK(fit.convergence.converged());
  CHECK(fit.convergence.boundary() == std::vector<std::string>{"sd(mu) = 0"});
  CHECK(fit.convergence.verdict().find("Boundary (singular) fit") != std::string::npos);
  const OneWay sums(table);
  const double n = kGroups * kRows;
  CHECK(fit.log_likelihood ==
        Approx(least_squares_log_likelihood(sums.within, static_cast<Index>(n))).epsilon(1e-12));
}

TEST_CASE("a change of unit only rescales the estimates") {
  for (const char* const kind : {"none", "power"}) {
    const MixedEffectsFit meters = fit_curves(scaled_curves(1.0), 1.0, kind);
    const MixedEffectsFit millimeters = fit_curves(scaled_curves(1000.0), 1000.0, kind);
    REQUIRE(meters.convergence.converged());
    REQUIRE(millimeters.convergence.converged());
    // Each is within 1e-6 standard errors of its optimum; the likelihood is flat to second order
    // there.
    CHECK(millimeters.estimate[0] == Approx(1000.0 * meters.estimate[0]).epsilon(1e-7));
    CHECK(millimeters.estimate[1] == Approx(meters.estimate[1]).epsilon(1e-7));
    CHECK(millimeters.random.back().sd()[0] ==
          Approx(1000.0 * meters.random.back().sd()[0]).epsilon(1e-5));
    CHECK(millimeters.log_likelihood + 300.0 * std::log(1000.0) ==
          Approx(meters.log_likelihood).epsilon(1e-9));
  }
}

TEST_CASE("estimates from simulated curves agree with the true values") {
  const MixedEffectsFit fit = fit_curves(scaled_curves(1.0), 1.0, "power");
  REQUIRE(fit.convergence.converged());
  // Within three standard errors; those of the deviations are about sd / sqrt(2 (G - 1)).
  const VectorXd errors = fit.standard_errors();
  CHECK(fit.estimate[0] == Approx(25.0).margin(3.0 * errors[0]));
  CHECK(fit.estimate[1] == Approx(0.07).margin(3.0 * errors[1]));
  CHECK(fit.random.back().sd()[0] == Approx(3.0).margin(3.0 * 3.0 / std::sqrt(28.0)));
  CHECK(fit.variance.delta() == Approx(1.0).margin(0.3));
  // A constant variance is nested in the variance function.
  CHECK(fit.log_likelihood > fit_curves(scaled_curves(1.0), 1.0, "none").log_likelihood);
}

TEST_CASE("constant-plus-power is never below its nested functions") {
  const Table table = scaled_curves(1.0);
  const double both = fit_curves(table, 1.0, "constant-plus-power").log_likelihood;
  // Two linearizations at nearly the same point differ by a few 1e-6.
  CHECK(both >= fit_curves(table, 1.0, "power").log_likelihood - 1e-5);
  CHECK(both >= fit_curves(table, 1.0, "none").log_likelihood - 1e-5);
}

TEST_CASE("the test of a vanishing constant does not depend on the unit of its column") {
  silvafit::Random random(7);
  std::vector<double> v;
  std::vector<double> y;
  for (int i = 0; i < 400; ++i) {
    v.push_back(0.5 + 0.01 * i);
    y.push_back(10.0 + random.normal() * (0.3 + v.back() * v.back()));
  }
  for (const double unit : {1.0, 1e-5, 1e5}) {
    Table table;
    std::vector<double> scaled;
    scaled.reserve(v.size());
    for (const double value : v) scaled.push_back(unit * value);
    table.set("v", scaled);
    table.set("y", y);
    ModelSpecification model = specify_model("y ~ a + 0*v", {}, table);
    model.variance = parse_variance_function("constant-plus-power(v)");
    const MixedEffectsFit fit =
        fit_lindstrom_bates(NonlinearModel(model, table), VectorXd::Constant(1, 10.0));
    INFO(unit << ": " << fit.convergence.verdict());
    CHECK(fit.convergence.converged());
    CHECK(!fit.convergence.has_boundary());
  }
}

TEST_CASE("constant-plus-power that is a power or a step is named") {
  const auto fitted = [](double constant, double exponent) {
    silvafit::Random random(7);
    std::vector<double> v;
    std::vector<double> y;
    for (int i = 0; i < 400; ++i) {
      v.push_back(0.5 + 0.005 * i);
      y.push_back(10.0 + random.normal() * (constant + std::pow(v.back() / 2.2, exponent)));
    }
    Table table;
    table.set("v", v);
    table.set("y", y);
    ModelSpecification model = specify_model("y ~ a + 0*v", {}, table);
    model.variance = parse_variance_function("constant-plus-power(v)");
    return fit_lindstrom_bates(NonlinearModel(model, table), VectorXd::Constant(1, 10.0));
  };
  // Without a constant the estimate of a constant is 0, or so small that it changes nothing.
  const MixedEffectsFit power = fitted(0.0, 2.0);
  INFO(power.convergence.verdict());
  CHECK(power.convergence.boundary() ==
        std::vector<std::string>{"the constant of the variance function = 0"});
  // 0.1 and 40 are felt at v = 2.2 and more, an eighth of the observations.
  const MixedEffectsFit step = fitted(1.0, 40.0);
  INFO(step.convergence.verdict());
  CHECK(step.convergence.status == ConvergenceStatus::kConverged);
  CHECK(step.variance.factors[0].delta[0] > 20.0);
  CHECK(step.convergence.has(Evidence::Kind::kPowerOfFew, "delta"));
}

TEST_CASE("strata and products are never below nested functions") {
  Table table = scaled_curves(1.0);
  TextColumn species;
  Random random(4);
  for (std::size_t i = 0; i < table.rows(); ++i) {
    species.append(random.uniform(0.0, 1.0) < 0.4 ? "fir" : "oak");
  }
  table.set("species", species);
  const auto log_likelihood = [&](const char* variance) {
    const MixedEffectsFit fit = fit_curves(table, 1.0, variance);
    INFO(variance << ": " << fit.convergence.verdict());
    CHECK(fit.convergence.converged());
    return fit.log_likelihood;
  };
  // Two linearizations at nearly the same point differ by a few 1e-6.
  constexpr double kSlack = 1e-5;
  const double none = log_likelihood("none");
  const double power = log_likelihood("power");
  const double stratum = log_likelihood("stratum(species)");
  const double strata = log_likelihood("power(fitted | species)");
  const double product = log_likelihood("stratum(species) * power");
  CHECK(stratum >= none - kSlack);
  CHECK(strata >= power - kSlack);
  CHECK(product >= power - kSlack);
  CHECK(product >= stratum - kSlack);
}

TEST_CASE("a trace has a line for each iteration and ends at the result") {
  const Table table = scaled_curves(1.0);
  ModelSpecification specification = specify_model("h ~ a*(1 - exp(-b*dbh))", {}, table);
  specification.random = {{.coefficients = {"a"}, .group = "plot"}};
  std::vector<std::string> lines;
  const MixedEffectsFit fit =
      fit_lindstrom_bates(NonlinearModel(specification, table),
                          Eigen::Vector2d(20.0, 0.1),
                          {.trace = [&](const std::string& line) { lines.push_back(line); }});
  REQUIRE(fit.convergence.converged());
  CHECK(lines.size() == static_cast<std::size_t>(fit.convergence.iterations));
  const std::string value = fmt::format("log-likelihood {:.6f}", fit.log_likelihood);
  INFO(lines.back());
  CHECK(lines.back().find(value) != std::string::npos);
  CHECK(lines.back().find('\n') == std::string::npos);
}

TEST_CASE("a factor represents the covariances of its form") {
  const VectorXd scales = Eigen::Vector3d(0.5, 2.0, 10.0);
  MatrixXd covariance(3, 3);
  covariance << 4.0, 1.0, -0.5, 1.0, 2.0, 0.3, -0.5, 0.3, 1.0;
  const RelativeFactor general({.coefficients = {"a", "b", "c"}}, scales);
  const MatrixXd factor = general.factor(general.from_covariance(covariance));
  CHECK((factor * factor.transpose() - covariance).norm() < 1e-13);
  CHECK(factor(0, 2) == 0.0);
  CHECK((general.factor(general.from_factor(factor)) - factor).norm() == 0.0);

  const RelativeFactor identity(
      {.coefficients = {"a", "b", "c"}, .covariance = Covariance::kIdentity}, scales);
  const MatrixXd multiple = identity.factor(VectorXd::Constant(1, 2.0));
  // In the effects' own units all have the same deviation.
  const VectorXd own = scales.cwiseProduct(multiple.diagonal());
  CHECK((own.array() - own[0]).abs().maxCoeff() < 1e-14);
  CHECK(identity.from_factor(multiple)[0] == Approx(2.0).epsilon(1e-14));
}

TEST_CASE("compound symmetry has one variance and one correlation, down to its limits") {
  const RandomEffects effects{.coefficients = {"a", "b", "c", "d"},
                              .covariance = Covariance::kCompoundSymmetry};
  const VectorXd scales = Eigen::Vector4d(0.5, 2.0, 10.0, 1.0);
  const RelativeFactor form(effects, scales);
  REQUIRE(form.parameter_count() == 2);
  const MatrixXd units = scales.asDiagonal();
  const double unit = std::pow(scales.prod(), -0.25);  // of the factor, so that its scale is one
  for (const double correlation : {-1.0 / 3.0, -0.2, 0.0, 0.6, 1.0}) {
    INFO(correlation);
    MatrixXd own = MatrixXd::Constant(4, 4, 2.25 * correlation);
    own.diagonal().setConstant(2.25);
    const MatrixXd scaled = unit * unit * units.inverse() * own * units.inverse();
    const VectorXd at = form.from_covariance(scaled);
    // The eigenvalues of a matrix with equal elements off the diagonal.
    CHECK(at[0] == Approx(1.5 * unit * unit * std::sqrt(1.0 - correlation)).margin(1e-7));
    const MatrixXd factor = form.factor(at);
    CHECK((factor * factor.transpose() - scaled).norm() < 1e-14 * scaled.norm() + 1e-15);
    CHECK(MatrixXd(factor.triangularView<Eigen::StrictlyUpper>()).norm() == 0.0);
    CHECK((form.from_factor(factor) - at).norm() < 1e-7);
    for (const double sign : {1.0, -1.0}) {
      const VectorXd moved = Eigen::Vector2d(sign * at[0], at[1]);
      const MatrixXd by_factor = MatrixXd::Random(4, 4).triangularView<Eigen::Lower>();
      const VectorXd gradient = form.gradient(moved, by_factor);
      for (Index k = 0; k < 2; ++k) {
        constexpr double kStep = 1e-5;
        const VectorXd change = kStep * VectorXd::Unit(2, k);
        const MatrixXd slope =
            (form.factor(moved + change) - form.factor(moved - change)) / (2.0 * kStep);
        // Central differences of second order.
        CHECK(gradient[k] == Approx(slope.cwiseProduct(by_factor).sum()).margin(1e-8));
      }
    }
  }
}

TEST_CASE("fits with confounded coefficients do not converge") {
  const Table table = one_way(2.0, 1.0);
  ModelSpecification model = specify_model("y ~ mu + nu", {}, table);
  model.random = {{.coefficients = {"mu"}, .group = "plot"}};
  const MixedEffectsFit fit =
      fit_lindstrom_bates(NonlinearModel(model, table), Eigen::Vector2d(5.0, 5.0));
  CHECK_FALSE(fit.convergence.converged());
  INFO(fit.convergence.verdict());
  CHECK(fit.convergence.verdict().find("not identifiable") != std::string::npos);
}

TEST_CASE("random effects that are impossible for the groups are reported") {
  const Table table = one_way(2.0, 1.0);
  const auto verdict = [](const ModelSpecification& model, const Table& data, double start) {
    const MixedEffectsFit fit =
        fit_lindstrom_bates(NonlinearModel(model, data), VectorXd::Constant(1, start));
    CHECK_FALSE(fit.convergence.converged());
    return fit.convergence.verdict();
  };
  SECTION("the fixed effects fit exactly") {
    Table constant = table;
    constant.set("y", std::vector<double>(table.rows(), 5.0));
    CHECK_THAT(verdict(one_way_model(table), constant, 5.0),
               Catch::Contains("perfect fit by the fixed effects"));
  }
  SECTION("one observation per group") {
    Table single = table;
    silvafit::data::TextColumn plots;
    for (std::size_t row = 0; row < table.rows(); ++row) plots.append(std::to_string(row));
    single.set("plot", plots);
    CHECK_THAT(verdict(one_way_model(single), single, 5.0),
               Catch::Contains("each group of plot has one observation"));
  }
}

TEST_CASE("start values of wrong length are refused") {
  const Table table = one_way(1.0, 1.0);
  CHECK_THROWS_AS(
      fit_lindstrom_bates(NonlinearModel(one_way_model(table), table), VectorXd::Zero(2)),
      silvafit::UsageError);
}
