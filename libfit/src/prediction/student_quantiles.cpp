// SPDX-License-Identifier: MIT
#include "prediction/student_quantiles.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

/// Without long doubles, which take ten times as long.
using StudentsT = boost::math::students_t_distribution<
    double,
    boost::math::policies::policy<boost::math::policies::promote_double<false>>>;

// Fewer degrees of freedom are rare, and the polynomial would need many more terms for them.
constexpr double kLeastFreedom = 3.0;
constexpr std::size_t kTerms = 32;
constexpr double kAccuracy = 1e-12;

double searched(double probability, double freedom) {
  return boost::math::quantile(StudentsT(freedom), probability);
}

/// The degrees of freedom of a place between -1 (infinite) and 1 (the fewest).
double freedom_at(double place) { return 2.0 * kLeastFreedom / (1.0 + place); }

}  // namespace

StudentQuantiles::StudentQuantiles(double probability) : probability_(probability) {
  std::vector<double> values(kTerms);
  const auto angle = [](std::size_t k) {
    return std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(kTerms);
  };
  for (std::size_t k = 0; k < kTerms; ++k) {
    values[k] = searched(probability, freedom_at(std::cos(angle(k))));
  }
  coefficients_.resize(kTerms);
  for (std::size_t j = 0; j < kTerms; ++j) {
    for (std::size_t k = 0; k < kTerms; ++k) {
      coefficients_[j] += values[k] * std::cos(static_cast<double>(j) * angle(k));
    }
    coefficients_[j] *= (j == 0 ? 1.0 : 2.0) / static_cast<double>(kTerms);
  }
  // Between the points, where the polynomial is least accurate.
  for (std::size_t k = 0; k <= kTerms; ++k) {
    const double place =
        std::cos(std::numbers::pi * static_cast<double>(k) / static_cast<double>(kTerms));
    const double freedom = place > -1.0 ? freedom_at(place) : 1e9;
    const double exact = searched(probability, freedom);
    if (std::abs(by_polynomial(freedom) - exact) <= kAccuracy * std::abs(exact)) continue;
    coefficients_.clear();
    return;
  }
}

/// Clenshaw's recurrence.
double StudentQuantiles::by_polynomial(double freedom) const {
  const double place = 2.0 * kLeastFreedom / freedom - 1.0;
  double next = 0.0;
  double after = 0.0;
  for (std::size_t j = kTerms - 1; j > 0; --j) {
    const double here = 2.0 * place * next - after + coefficients_[j];
    after = next;
    next = here;
  }
  return place * next - after + coefficients_[0];
}

double StudentQuantiles::at(double freedom) const {
  if (!(freedom > 0.0)) return kNaN;
  const bool is_covered = !coefficients_.empty() && freedom >= kLeastFreedom;
  return is_covered ? by_polynomial(freedom) : searched(probability_, freedom);
}

}  // namespace silvafit::fit
