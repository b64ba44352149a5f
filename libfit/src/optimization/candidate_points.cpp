// SPDX-License-Identifier: MIT
#include "optimization/candidate_points.hpp"

#include <algorithm>
#include <boost/math/special_functions/prime.hpp>
#include <cmath>

namespace silvafit::fit {
namespace {

/// Radical inverse of a number in a base.
double halton(std::size_t number, std::size_t base) {
  double result = 0.0;
  double fraction = 1.0;
  for (; number > 0; number /= base) {
    fraction /= static_cast<double>(base);
    result += fraction * static_cast<double>(number % base);
  }
  return result;
}

/// A coordinate between 0 and 1 of the points of a sequence. In larger bases the first points of
/// Halton's sequence lie on a line; there it is Richtmyer's (1951), the fractions of multiples of
/// the root of a prime.
double evenly_spread(std::size_t number, std::size_t prime) {
  constexpr std::size_t kLargestBase = 37;
  if (prime <= kLargestBase) return halton(number, prime);
  const double multiple = static_cast<double>(number) * std::sqrt(static_cast<double>(prime));
  return multiple - std::floor(multiple);
}

double median_magnitude(VectorXd values) {
  values = values.cwiseAbs().eval();
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void add_scale(std::vector<double>& scales, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return;
  const bool is_new = std::ranges::none_of(
      scales, [&](double other) { return std::abs(std::log10(value / other)) < 0.5; });
  if (is_new) scales.push_back(value);
}

}  // namespace

CandidatePoints::CandidatePoints(const NonlinearModel& model, Index coefficients)
    : coefficients_(coefficients), scales_{1.0} {
  const ModelSpecification& specification = model.specification();
  for (const std::string& name : specification.formula.right.variables()) {
    if (std::ranges::find(specification.parameters, name, &ParameterModel::name) !=
        specification.parameters.end()) {
      continue;
    }
    const double typical = median_magnitude(model.column(name));
    add_scale(scales_, 1.0 / typical);
    add_scale(scales_, typical);
  }
}

VectorXd CandidatePoints::operator()(std::size_t number) const {
  VectorXd point(coefficients_);
  for (Index k = 0; k < coefficients_; ++k) {
    const double u = evenly_spread(number, boost::math::prime(static_cast<unsigned>(k)));
    point[k] = u < 0.5 ? magnitude(2.0 * u) : -magnitude(2.0 * u - 1.0);
  }
  return point;
}

double CandidatePoints::magnitude(double u) const {
  constexpr double kNear = 0.75;
  if (u >= kNear) return std::pow(10.0, -8.0 + 16.0 * (u - kNear) / (1.0 - kNear));
  const double place = u / kNear * static_cast<double>(scales_.size());
  const auto scale = std::min(static_cast<std::size_t>(place), scales_.size() - 1);
  return scales_[scale] * std::pow(10.0, -1.5 + 3.0 * (place - static_cast<double>(scale)));
}

}  // namespace silvafit::fit
