// SPDX-License-Identifier: MIT
#include "fit_model/bounded_search.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/random.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::string name_of(Index j) { return "x" + std::to_string(j); }

FitResult result_at(const VectorXd& x, double value) {
  FitResult result{.fit = FittedModel({.formula = data::parse_formula("y ~ x0")})};
  FittedModel& fit = result.fit;
  fit.estimate = x;
  for (Index j = 0; j < x.size(); ++j) fit.coefficient_names.push_back(name_of(j));
  fit.log_likelihood = value;
  fit.parameter_count = static_cast<int>(x.size());
  fit.convergence = {.status = ConvergenceStatus::kConverged, .findings = {{.names = {"Found."}}}};
  return result;
}

/// A log-likelihood -(x - m)' A (x - m) / 2, whose maximum with some x held is known.
struct Quadratic {
  MatrixXd curvature;
  VectorXd peak;
  int fits = 0;

  VectorXd gradient(const VectorXd& x) const { return -curvature * (x - peak); }

  FitResult fit(const HeldValues& held) {
    ++fits;
    VectorXd x = peak;
    std::vector<Index> free;
    std::vector<Index> fixed;
    for (Index j = 0; j < x.size(); ++j) {
      const auto found = held.find(name_of(j));
      (found == held.end() ? free : fixed).push_back(j);
      if (found != held.end()) x[j] = found->second;
    }
    if (!free.empty() && !fixed.empty()) {
      const VectorXd away = x(fixed) - peak(fixed);
      const MatrixXd own = curvature(free, free);
      x(free) -= own.partialPivLu().solve(curvature(free, fixed) * away);
    }
    return result_at(x, 0.5 * (x - peak).dot(gradient(x)));
  }

  HeldPoint slopes(const FittedModel& fit, const HeldValues& held) const {
    HeldPoint point{.value = fit.log_likelihood};
    for (const auto& [name, value] : held) {
      point.slopes[name] = gradient(fit.estimate)[std::stoi(name.substr(1))];
    }
    return point;
  }

  FitResult run(const std::map<std::string, Bounds>& bounds) {
    const HeldFit held_fit = [&](const HeldValues& held, const FittedModel*) { return fit(held); };
    const SlopesOf slopes_of = [&](const FittedModel& at, const HeldValues& held) {
      return slopes(at, held);
    };
    return BoundedSearch(bounds, held_fit, slopes_of).run();
  }
};

Quadratic random_quadratic(Random& random, Index size) {
  MatrixXd root(size, size);
  for (double& value : root.reshaped()) value = random.normal();
  Quadratic result{.curvature = root * root.transpose() + 0.1 * MatrixXd::Identity(size, size),
                   .peak = VectorXd(size)};
  for (double& value : result.peak) value = 2.0 * random.normal();
  return result;
}

/// One coefficient; log-likelihood p with the slope dp. A fit without bounds is the highest point,
/// one from nearby goes uphill in small steps.
struct Curve {
  std::function<double(double)> value;
  std::function<double(double)> slope;
  std::optional<double> peak;  ///< none where the fit runs away

  double uphill(double x) const {
    for (int step = 0; step < 20000; ++step) x += 1e-3 * slope(x);
    return x;
  }

  FitResult fit(const HeldValues& held, const FittedModel* nearby) const {
    const auto found = held.find("x0");
    if (found != held.end()) return at(found->second);
    if (nearby == nullptr) return peak ? at(*peak) : running_away(1e9);
    const double end = uphill(nearby->estimate[0]);
    return std::abs(slope(end)) > 1e-4 ? running_away(end) : at(end);
  }
  FitResult running_away(double x) const {
    FitResult result = at(x);
    result.fit.convergence = {.findings = {{.names = {"It runs away."}}}};
    return result;
  }

  FitResult at(double x) const { return result_at(VectorXd::Constant(1, x), value(x)); }

  FittedModel run(const Bounds& bounds) const {
    const HeldFit held_fit = [&](const HeldValues& held, const FittedModel* nearby) {
      return fit(held, nearby);
    };
    const SlopesOf slopes_of = [&](const FittedModel& found, const HeldValues& held) {
      HeldPoint point{.value = found.log_likelihood};
      if (!held.empty()) point.slopes["x0"] = slope(found.estimate[0]);
      return point;
    };
    return BoundedSearch({{"x0", bounds}}, held_fit, slopes_of).run().fit;
  }
};

/// Maxima near -0.96 and 1.04, the second one higher; a minimum near 0.08.
Curve two_peaks() {
  return {.value = [](double x) { return -std::pow(x * x - 1.0, 2) + 0.3 * x; },
          .slope = [](double x) { return -4.0 * x * (x * x - 1.0) + 0.3; },
          .peak = 1.0355754};
}

}  // namespace

TEST_CASE("a maximum within the bounds costs one fit") {
  Random random(1);
  Quadratic quadratic = random_quadratic(random, 3);
  std::map<std::string, Bounds> bounds;
  for (Index j = 0; j < 3; ++j) {
    bounds[name_of(j)] = {quadratic.peak[j] - 0.1, quadratic.peak[j] + 0.1};
  }
  const FitResult result = quadratic.run(bounds);
  CHECK(quadratic.fits == 1);
  CHECK(result.fit.estimate == quadratic.peak);
  CHECK(!result.fit.convergence.has_boundary());
}

TEST_CASE("the maximum of a concave likelihood in a box fulfils Kuhn and Tucker's conditions") {
  // Of a concave function a point that fulfils them is the maximum; no two sets of bounds share it.
  Random random(2);
  for (int repeat = 0; repeat < 200; ++repeat) {
    const auto size = static_cast<Index>(1 + random.below(4));
    Quadratic quadratic = random_quadratic(random, size);
    std::map<std::string, Bounds> bounds;
    for (Index j = 0; j < size; ++j) {
      const double low = random.uniform(-2.0, 1.0);
      bounds[name_of(j)] = {low, low + random.uniform(0.2, 2.0)};
    }
    const FittedModel fit = quadratic.run(bounds).fit;
    REQUIRE(fit.convergence.converged());
    const VectorXd slope = quadratic.gradient(fit.estimate);
    std::size_t at_bounds = 0;
    for (Index j = 0; j < size; ++j) {
      const Bounds& range = bounds[name_of(j)];
      CHECK(fit.estimate[j] >= range.low);
      CHECK(fit.estimate[j] <= range.high);
      const bool is_low = fit.estimate[j] == range.low;
      const bool is_high = fit.estimate[j] == range.high;
      at_bounds += is_low || is_high ? 1 : 0;
      // Solved by elimination, with curvatures of order one.
      if (!is_high) CHECK(slope[j] <= 1e-8);
      if (!is_low) CHECK(slope[j] >= -1e-8);
    }
    CHECK(fit.convergence.boundary().size() == at_bounds);
    CHECK(fit.parameter_count == size + static_cast<Index>(at_bounds));
  }
}

TEST_CASE("a maximum inside is found though the likelihood is higher outside") {
  const Curve curve = two_peaks();
  // At 0 the likelihood rises out of the range: that is a maximum too, but the lower one.
  for (const Bounds& bounds : {Bounds{-2.0, 0.0}, Bounds{-2.0, -0.5}}) {
    const FittedModel fit = curve.run(bounds);
    REQUIRE(fit.convergence.converged());
    CHECK(!fit.convergence.has_boundary());
    // The root of 4 x^3 - 4 x = 0.3 between -1 and 0, by Newton's method.
    CHECK(fit.estimate[0] == Approx(-0.9601496).epsilon(1e-6));
  }
  const FittedModel upper = curve.run({-0.5, 0.5});
  CHECK(upper.estimate[0] == 0.5);
  CHECK_THAT(upper.convergence.verdict(), Contains("x0 = 0.5, its upper bound"));
  const FittedModel lower = curve.run({1.5, 3.0});
  CHECK(lower.estimate[0] == 1.5);
  CHECK_THAT(lower.convergence.verdict(), Contains("x0 = 1.5, its lower bound"));
}

TEST_CASE("a fit that runs away does not keep a bounded one from its maximum") {
  // The slope at both ends leads inwards; uphill() diverges from there, since the curve is steep.
  const Curve steep{.value = [](double x) { return -std::pow(x - 7.3, 4); },
                    .slope = [](double x) { return -4.0 * std::pow(x - 7.3, 3); },
                    .peak = std::nullopt};
  CHECK(std::isnan(steep.uphill(100.0)));
  const FittedModel fit = steep.run({-80.0, 100.0});
  REQUIRE(fit.convergence.converged());
  CHECK(!fit.convergence.has_boundary());
  CHECK(fit.estimate[0] == Approx(7.3).epsilon(0.05));  // a flat maximum, by small steps

  const Curve rising{.value = [](double x) { return -std::exp(-x); },
                     .slope = [](double x) { return std::exp(-x); },
                     .peak = std::nullopt};
  CHECK(rising.run({0.0, 5.0}).estimate[0] == 5.0);
  CHECK(rising.run({0.0, 5.0}).convergence.converged());
}

TEST_CASE("a likelihood that is higher towards an infinite end of the range has no maximum") {
  // Maxima at -10, outside, and 0.5; from 1.6 on it rises as a root.
  const auto value = [](double x) {
    return x > 1.6 ? std::sqrt(x - 1.6) : (x < -5.0 ? -(x + 10.0) * (x + 10.0) : x - x * x);
  };
  const auto slope = [](double x) {
    return x > 1.6 ? 0.5 / std::sqrt(x - 1.6) : (x < -5.0 ? -2.0 * (x + 10.0) : 1.0 - 2.0 * x);
  };
  const Curve curve{.value = value, .slope = slope, .peak = -10.0};
  const double infinity = std::numeric_limits<double>::infinity();
  const FittedModel open = curve.run({0.0, infinity});
  CHECK(open.convergence.status == ConvergenceStatus::kNoMaximum);
  CHECK_THAT(open.convergence.verdict(), Contains("x0"));
  const FittedModel closed = curve.run({0.0, 1.5});
  REQUIRE(closed.convergence.converged());
  CHECK(closed.estimate[0] == Approx(0.5).epsilon(1e-6));
}

TEST_CASE("without a point that fulfils the conditions there is no convergence") {
  // Increases without bound, so that there is no finite maximum above 0.
  const Curve rising{.value = [](double x) { return std::log1p(std::exp(x)); },
                     .slope = [](double x) { return 1.0 / (1.0 + std::exp(-x)); },
                     .peak = std::nullopt};
  const FittedModel fit = rising.run({0.0, std::numeric_limits<double>::infinity()});
  CHECK(!fit.convergence.converged());
}
