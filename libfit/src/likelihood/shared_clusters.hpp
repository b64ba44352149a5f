// SPDX-License-Identifier: MIT
// Clusters of one data set on the ranks of a job.
#pragma once

#include <vector>

#include "model/coefficient_frame.hpp"
#include "silvafit/fit/matrices.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {

/// The clusters of this rank among those of all.
///
/// The model of each rank has its own clusters. Results of all data are sums over blocks of
/// clusters. The blocks are the same for any number of ranks, and their sums are added in order, so
/// that all ranks get the same bytes for any number of ranks. The scales of the parameters, which
/// are not such sums, are computed from a sample that all ranks have.
struct SharedClusters {
  /// First cluster of each block of this rank, and the end of the last; the blocks of rank r come
  /// before those of rank r + 1. One number: this rank has none.
  std::vector<Index> block_begin{0};
  Index observations = 0;               ///< of all ranks
  CoefficientFrame frame{};             ///< of the coefficients, from the sample
  std::vector<TypicalValue> typical{};  ///< as in VarianceData, from the sample
};

/// The sum of the blocks of all ranks, added in order. All ranks must call it.
/// \param own   a vector for each block of this rank
/// \param size  of each vector
VectorXd sum_over_ranks(const std::vector<VectorXd>& own, Index size);

/// Whether a condition holds on at least one rank. All ranks must call it.
bool is_on_any_rank(bool is_here);

}  // namespace silvafit::fit
