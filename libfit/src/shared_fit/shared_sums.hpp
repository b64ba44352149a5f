// SPDX-License-Identifier: MIT
// Sums over the observations of all ranks.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "likelihood/shared_clusters.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// A rank's model and the range of its clusters.
struct SharedModel {
  const NonlinearModel& model;
  const SharedClusters& clusters;

  /// Groups of these clusters.
  Eigen::Index group_count() const { return model.cluster_begin(clusters.block_begin.back()); }
};

/// Numbers of this rank, added to those of all others.
std::vector<double> added_up(const std::vector<double>& own);
std::uint64_t added_up(std::uint64_t own);

/// Texts of all ranks, in the order of the ranks.
std::vector<std::string> joined_texts(const std::vector<std::string>& own);
/// Columns of all ranks, in the order of the ranks.
/// \param own  (rows x any)
Eigen::MatrixXd joined_columns(const Eigen::MatrixXd& own);

/// Sets the statistics of the fit to all observations: R2, errors, shares of the variance.
/// \param local  the fit with the fitted values of this rank
void add_shared_statistics(const SharedModel& shared,
                           const MixedEffectsFit& local,
                           FittedModel& fit);

/// The smallest and the largest value of each column that the mean uses.
std::vector<ColumnRange> shared_ranges(const SharedModel& shared,
                                       const std::vector<ColumnRange>& of_sample);

}  // namespace silvafit::fit
