// SPDX-License-Identifier: MIT
#include "lindstrom_bates/lindstrom_bates.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/model_specification.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// Pairs of rows of y ~ z*b + x*b^2, with (z, x) = (1, 0) and (0, 0.2), whose squares
/// (y1 - b)^2 + (y2 - 0.2 b^2)^2 have their minimum at b = 0.5. The residual of the second row is
/// so large that Gauss and Newton's step is a fiftieth of the distance to the minimum.
data::Table slow_squares() {
  constexpr double kMinimum = 0.5;
  constexpr double kBend = 0.2;
  const double slope = 2.0 * kBend * kMinimum;
  const double second = 0.98 * (1.0 + slope * slope) / (2.0 * kBend);  // residual of the second row
  const double first = -slope * second;  // so that the derivative of the squares is zero
  std::vector<double> z;
  std::vector<double> x;
  std::vector<double> y;
  for (int pair = 0; pair < 1000; ++pair) {
    z.insert(z.end(), {1.0, 0.0});
    x.insert(x.end(), {0.0, kBend});
    y.insert(y.end(), {kMinimum + first, kBend * kMinimum * kMinimum + second});
  }
  data::Table table;
  table.set("w", std::vector<double>(z.size(), 1.0));
  table.set("z", z);
  table.set("x", x);
  table.set("y", y);
  return table;
}

}  // namespace

TEST_CASE("a limit of steps that ends penalized least squares is not convergence") {
  const data::Table table = slow_squares();
  ModelSpecification specification = specify_model("y ~ z*b + x*b^2", {}, table);
  specification.variance = parse_variance_function("power(w, delta = 0.5)");
  const NonlinearModel model(specification, table);
  const Eigen::VectorXd start = Eigen::VectorXd::Constant(1, 0.9);
  const auto outcome_after = [&](int alternations) {
    const MixedEffectsOptions options{.maximum_iterations = alternations};
    LindstromBates engine(
        model, pooled_fit(model, start, options), specification.variance, options);
    return engine.run(engine.start(1.0), Alternation::kCareful);
  };
  // A hundred steps end at 0.517.
  CHECK_FALSE(outcome_after(1).converged);
  const LindstromBatesOutcome end = outcome_after(200);
  REQUIRE(end.converged);
  // The tolerance of penalized least squares, 1e-7 squared standard errors, is a distance of
  // 0.0009.
  CHECK(end.state.scale[0] * end.state.beta[0] == Approx(0.5).margin(1e-3));
}
