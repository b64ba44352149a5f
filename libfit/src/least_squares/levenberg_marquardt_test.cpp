// SPDX-License-Identifier: MIT
#include "least_squares/levenberg_marquardt.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// The descent of a Chapman-Richards curve from b = 0.3 and c = 3, with x and y in other units.
/// \param x_unit, y_unit  powers of 2, by which doubles are multiplied exactly
Descent descent_in_units(double x_unit, double y_unit) {
  std::vector<double> x, y;
  for (int i = 1; i <= 20; ++i) {
    const double noise = 0.05 * std::sin(7.0 * i);
    x.push_back(x_unit * i);
    y.push_back(y_unit * (25.0 * std::pow(1.0 - std::exp(-0.15 * i), 1.4) + noise));
  }
  data::Table table;
  table.set("x", x);
  table.set("y", y);
  const NonlinearModel model(specify_model("y ~ a*(1 - exp(-b*x))^c", {}, table), table);
  ProjectedModel projected(model);
  Eigen::VectorXd start(3);
  start << 0.0, 0.3 / x_unit, 3.0;
  return descend(projected, projected.nonlinear_part(start), {});
}

}  // namespace

TEST_CASE("a descent takes the same steps in all units") {
  const Descent usual = descent_in_units(1.0, 1.0);
  CHECK(usual.coefficients[1] == Approx(0.15).epsilon(0.05));
  for (const double x_unit : {std::ldexp(1.0, 30), std::ldexp(1.0, -30)}) {
    for (const double y_unit : {1.0, std::ldexp(1.0, 30), std::ldexp(1.0, -30)}) {
      INFO(x_unit << " " << y_unit);
      const Descent other = descent_in_units(x_unit, y_unit);
      CHECK(other.iterations == usual.iterations);
      CHECK(other.coefficients[0] == usual.coefficients[0] * y_unit);
      CHECK(other.coefficients[1] == usual.coefficients[1] / x_unit);
      CHECK(other.coefficients[2] == usual.coefficients[2]);
    }
  }
}
