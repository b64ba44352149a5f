// SPDX-License-Identifier: MIT
// The residuals of a response's final model: standardized, and by the distance between trees.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// The result of the last level that chose a model; none if no level did.
const fit::FitResult* final_result(const ResponseStudy& result);

/// (N) conditional residuals in residual standard deviations, in the order of `final.rows`.
Eigen::VectorXd standardized_residuals(const ResponseStudy& result,
                                       const data::Table& table,
                                       const fit::FitResult& final);

/// Residuals of trees with a position, whose trees are compared within plots.
struct PlacedResiduals {
  Eigen::VectorXd residuals;                     ///< (N)
  Eigen::MatrixX2d positions_m;                  ///< (N x 2), finite for the trees of `plots`
  std::vector<std::vector<Eigen::Index>> plots;  ///< of at least two trees; those of a time each
};

/// The standardized residuals of the final model; no plots without one or without positions.
/// Plots of more than 3,000 trees are left out: all of their pairs take too long.
PlacedResiduals placed_residuals(const ResponseStudy& result, const data::Table& table);

/// The correlation of each tree's residual with that of the nearest tree of its plot.
struct NeighborCorrelation {
  double correlation = 0.0;
  /// The sum of products in its standard deviations if residuals are independent with variance 1.
  double z = 0.0;
};
NeighborCorrelation neighbor_correlation(const PlacedResiduals& placed);

/// Half the mean squared difference of residuals, in 10 classes of distance up to half the largest
/// one within a plot; classes of fewer than 30 pairs are left out (Journel and Huijbregts 1978,
/// Mining Geostatistics, section III.B.7).
std::vector<VariogramClass> residual_variogram(const PlacedResiduals& placed);

}  // namespace silvafit::study
