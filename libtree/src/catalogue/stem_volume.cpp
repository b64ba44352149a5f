// SPDX-License-Identifier: MIT
#include "silvafit/tree/stem_volume.hpp"

#include <array>
#include <cstddef>
#include <numbers>
#include <vector>

#include "morphology/breast_height.hpp"

namespace silvafit::tree {
namespace {

/// Abramowitz and Stegun 1964, table 25.4, n = 5.
constexpr std::array<double, 5> kNodes{
    -0.906179845938663993, -0.538469310105683091, 0.0, 0.538469310105683091, 0.906179845938663993};
constexpr std::array<double, 5> kWeights{0.236926885056189088,
                                         0.478628670499366468,
                                         0.568888888888888889,
                                         0.478628670499366468,
                                         0.236926885056189088};
constexpr std::size_t kPartsBelow = 4;
constexpr std::size_t kPartsAbove = 12;

struct Rule {
  std::vector<double> heights_m{};
  std::vector<double> weights_m{};

  void add(double from_m, double to_m, std::size_t parts) {
    const double half = (to_m - from_m) / static_cast<double>(2 * parts);
    for (std::size_t part = 0; part < parts; ++part) {
      const double middle = from_m + half * static_cast<double>(2 * part + 1);
      for (std::size_t i = 0; i < kNodes.size(); ++i) {
        heights_m.push_back(middle + half * kNodes[i]);
        weights_m.push_back(half * kWeights[i]);
      }
    }
  }
};

}  // namespace

double stem_volume_m3(const Taper& taper, double h_m, double dbh_cm) {
  Rule rule;
  rule.add(0.0, kBreastHeight, kPartsBelow);
  rule.add(kBreastHeight, h_m, kPartsAbove);
  const std::vector<double> diameters_cm = taper.diameters_cm(rule.heights_m, h_m, dbh_cm);
  double sum = 0.0;
  for (std::size_t i = 0; i < diameters_cm.size(); ++i) {
    sum += rule.weights_m[i] * diameters_cm[i] * diameters_cm[i];
  }
  constexpr double kSquareCentimeters = 1e4;
  return std::numbers::pi / 4.0 * sum / kSquareCentimeters;
}

}  // namespace silvafit::tree
