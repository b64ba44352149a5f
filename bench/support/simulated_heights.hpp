// SPDX-License-Identifier: MIT
// Heights of trees on plots with known truth, drawn with fixed seeds.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::bench {

/// h = 1.3 + (a + u) (1 - exp(-(b + v + c C) d)) + e, with (u, v, w) ~ N(0, Psi) by plot, w on c,
/// and sd(e) = sigma |mean|^delta.
struct HeightTruth {
  Eigen::Vector3d fixed{30.0, 0.035, 0.006};  ///< a, b, b:C
  Eigen::Matrix3d psi = Eigen::Matrix3d::Zero();
  double sigma = 1.5;
  double delta = 0.0;
  /// Plots where the rate b of some C would be less are drawn again.
  double least_rate = 0.002;
  double mean_dbh = 20.0;  ///< [cm]; DBH = 5 + gamma
  double sd_dbh = 9.0;

  /// Effects on a and b with sd 2 and 0.004 and correlation -0.5; the residual sd 1.5 m, or
  /// 0.25 mean^0.6 for "power".
  static HeightTruth ordinary(bool has_power);
  /// Height of Chinese fir (SM) in Table 5 of Wang et al. 2023, doi:10.3390/f14030639: sd 2.23,
  /// 0.0087, 0.0054; correlations -0.986, 0.883, -0.947, with those of b:C reversed since the
  /// paper's sign of b:C is; lifted to a positive semidefinite matrix. The residual sd is 2.2 m.
  static HeightTruth near_singular();
};

/// Trees on plots, by plot: columns plot (text), C (0, 0.25 .. 1), D [cm, 0.1] and H [m, not
/// rounded]. The stream is the number of the data set. \param smallest, largest  trees of a plot,
/// uniform between them
data::Table simulated_heights(const HeightTruth& truth,
                              std::size_t plots,
                              std::size_t smallest,
                              std::size_t largest,
                              std::uint64_t seed,
                              std::uint64_t stream);

/// The model of these heights. \param random  e.g. "a + b | plot" \param variance  e.g. "power"
fit::ModelSpecification height_model(const std::string& random,
                                     const std::string& variance,
                                     const data::Table& table);

}  // namespace silvafit::bench
