// SPDX-License-Identifier: MIT
// Positions, DBH and elevations of simulated trees, and the smooth surfaces they follow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/study/simulate.hpp"

namespace silvafit::study {

/// The purposes of random numbers. Each purpose and species has its own stream,
/// so that a change in one part of a design does not change the draws of the others.
enum class Draw : std::uint64_t {
  kPatches = 1,
  kStems,
  kTerrain,
  kDbh,
  kEffects,
  kResiduals,
  kShape,
  kCrowding
};

inline std::uint64_t stream_of(Draw purpose, std::size_t species = 0, std::size_t response = 0) {
  return (static_cast<std::uint64_t>(purpose) << 32U) + (species << 2U) + response;
}

/// A value rounded to so many per unit: 10 for one decimal.
double rounded(double value, double per_unit);

struct Stem {
  std::size_t plot = 0;     ///< index in the design
  std::size_t species = 0;  ///< index in the design
  double x = 0.0;
  double y = 0.0;
};

/// Stems by plot, at least the minimum distance apart (sequential inhibition), each species in
/// patches of its own.
/// \throws InputError if there is no room for them
std::vector<Stem> place_stems(const SimulationDesign& design, std::uint64_t seed);

/// Factors on DBH - minimum, one a plot, of one species.
std::vector<double> draw_plot_factors(const SimulationDesign& design,
                                      std::size_t species,
                                      std::uint64_t seed);

/// DBH of each stem [cm].
/// \param plot_factors  by species and plot
std::vector<double> draw_dbh(const SimulationDesign& design,
                             const std::vector<Stem>& stems,
                             const std::vector<std::vector<double>>& plot_factors,
                             std::uint64_t seed);

/// Elevation of each stem [m].
std::vector<double> draw_elevation(const SimulationDesign& design,
                                   const std::vector<Stem>& stems,
                                   std::uint64_t seed);

/// A smooth random function of the plane, close to a standard Gaussian field: a sum of cosine waves
/// with random directions and phases.
/// Source: random Fourier features of a Gaussian covariance, exp(-d^2 / (2 length^2)); Rahimi and
/// Recht 2007, Advances in Neural Information Processing Systems 20.
class SmoothField {
 public:
  SmoothField(double length_m, Random& random);
  double operator()(double x, double y) const;

 private:
  struct Wave {
    double kx = 0.0;
    double ky = 0.0;
    double phase = 0.0;
  };
  std::vector<Wave> waves_;
};

}  // namespace silvafit::study
