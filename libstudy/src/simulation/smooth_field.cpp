// SPDX-License-Identifier: MIT
#include "simulation/smooth_field.hpp"

#include <cmath>
#include <numbers>

namespace silvafit::study {

SmoothField::SmoothField(double length_m, Random& random) {
  constexpr std::size_t kWaves = 64;
  waves_.resize(kWaves);
  for (Wave& wave : waves_) {
    wave.kx = random.normal(0.0, 1.0 / length_m);
    wave.ky = random.normal(0.0, 1.0 / length_m);
    wave.phase = random.uniform(0.0, 2.0 * std::numbers::pi);
  }
}

double SmoothField::operator()(double x, double y) const {
  double sum = 0.0;
  for (const Wave& wave : waves_) sum += std::cos(wave.kx * x + wave.ky * y + wave.phase);
  return std::sqrt(2.0 / static_cast<double>(waves_.size())) * sum;
}

}  // namespace silvafit::study
