// SPDX-License-Identifier: MIT
#include "prediction/student_quantiles.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

using silvafit::fit::StudentQuantiles;

TEST_CASE("quantiles of t distributions agree with a search for each") {
  for (const double probability : {0.6, 0.9, 0.975, 0.995, 0.9995, 1.0 - 1e-7, 0.025}) {
    const StudentQuantiles quantiles(probability);
    double freedom = 1.0;
    for (int k = 0; k < 400; ++k, freedom *= 1.05) {
      const double exact =
          boost::math::quantile(boost::math::students_t_distribution<double>(freedom), probability);
      // What the polynomial is held to, and a last digit or two of both.
      CHECK(quantiles.at(freedom) == Approx(exact).epsilon(5e-12));
    }
  }
  // Closed forms of Shaw 2006: tan(pi (p - 1/2)) for one degree of freedom, and for four.
  const StudentQuantiles quantiles(0.975);
  CHECK(quantiles.at(1.0) == Approx(std::tan(std::numbers::pi * 0.475)).epsilon(1e-12));
  const double root = std::sqrt(4.0 * 0.975 * 0.025);
  const double four = 2.0 * std::sqrt(std::cos(std::acos(root) / 3.0) / root - 1.0);
  CHECK(quantiles.at(4.0) == Approx(four).epsilon(1e-12));
  CHECK(std::isnan(StudentQuantiles(0.975).at(0.0)));
  CHECK(std::isnan(StudentQuantiles(0.975).at(std::numeric_limits<double>::quiet_NaN())));
}
