// SPDX-License-Identifier: MIT
#include <array>
#include <cstddef>
#include <numbers>
#include <vector>

#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/taper.hpp"

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

  /// Calls a function with the nodes and weights of equal parts of an interval.
  template <class Function>
  static void for_each(double from, double to, std::size_t parts, Function function) {
    const double half = (to - from) / static_cast<double>(2 * parts);
    for (std::size_t part = 0; part < parts; ++part) {
      const double middle = from + half * static_cast<double>(2 * part + 1);
      for (std::size_t i = 0; i < kNodes.size(); ++i) {
        function(middle + half * kNodes[i], half * kWeights[i]);
      }
    }
  }
  void add(double height_m, double weight_m) {
    heights_m.push_back(height_m);
    weights_m.push_back(weight_m);
  }
};

}  // namespace

double stem_volume_m3(const Taper& taper, double h_m, double dbh_cm) {
  Rule rule;
  // Taper equations have the fourth root of the height, which is not smooth at the ground: there
  // the integral is that of u, x = 1.3 u^4.
  Rule::for_each(0.0, 1.0, kPartsBelow, [&rule](double u, double weight) {
    rule.add(kBreastHeight * u * u * u * u, weight * 4.0 * kBreastHeight * u * u * u);
  });
  Rule::for_each(kBreastHeight, h_m, kPartsAbove, [&rule](double height_m, double weight) {
    rule.add(height_m, weight);
  });
  const std::vector<double> diameters_cm = taper.diameters_cm(rule.heights_m, h_m, dbh_cm);
  double sum = 0.0;
  for (std::size_t i = 0; i < diameters_cm.size(); ++i) {
    sum += rule.weights_m[i] * diameters_cm[i] * diameters_cm[i];
  }
  constexpr double kSquareCentimeters = 1e4;
  return std::numbers::pi / 4.0 * sum / kSquareCentimeters;
}

}  // namespace silvafit::tree
