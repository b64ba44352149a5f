// SPDX-License-Identifier: MIT
// The directions of the arguments of a mean in which it is bent, and those in which it is straight.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "prediction/row_mean.hpp"

namespace silvafit::fit {

/// What is not known of a row's arguments, in independent standard normal variables: the arguments
/// are center + root u, and the mean is f(center + root u) + straight t.
///
/// A gradient that stays in a subspace wherever it is taken, but for a constant part, belongs to a
/// function that is bent in that subspace only. What is straight has a normal distribution and
/// needs no points.
struct BentDirections {
  Eigen::MatrixXd root{};  ///< (K + U x q) q directions, the first that of the steepest mean
  double straight = 0.0;   ///< standard deviation of what is straight
};

/// The number of places at which bent_directions() takes gradients, each of q numbers a row.
Eigen::Index bend_places(Eigen::Index width);

/// \param mean       of some rows
/// \param center     (N x K + U) their arguments
/// \param gradient   (N x K + U) of the mean there
/// \param roots      (N) R with R R' the covariance of the arguments, as rotated_root() has it
/// \param tolerance  (N) changes of the mean that do not count
/// \param split      whether straight directions may be left out; else only directions that do not
///   change the mean at all are: where the residual's spread follows the mean, this is no normal
///   distribution
/// \returns (N)
std::vector<BentDirections> bent_directions(const RowMean& mean,
                                            const Eigen::MatrixXd& center,
                                            const Eigen::MatrixXd& gradient,
                                            const std::vector<Eigen::MatrixXd>& roots,
                                            const Eigen::VectorXd& tolerance,
                                            bool split);

}  // namespace silvafit::fit
