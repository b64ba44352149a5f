// SPDX-License-Identifier: MIT
// Sums over rows, the inner loops of all estimates by group.
//
// All functions use the vector instructions of the processor. A result depends on the values and
// their number only, not on their address or on the number of threads. Rows are added to 16 partial
// sums (8 in weighted_products), which are then added pairwise, in the same way on every processor.
// Processors without fused multiply-add round each product separately, so that the last digit may
// differ.
//
// Values need no alignment. The sum of no rows is zero. NaN and infinities propagate.
#pragma once

#include <cstddef>
#include <span>

namespace silvafit::data {

/// sum a_i
double sum(const double* a, std::size_t rows);

/// sum a_i b_i
double dot(const double* a, const double* b, std::size_t rows);

/// sum w_i a_i b_i, as (w_i a_i) b_i
double weighted_dot(const double* w, const double* a, const double* b, std::size_t rows);

/// The sum of each column over each segment of consecutive rows; equals sum() of each.
///
/// \param columns  (C) pointers to the first row
/// \param begins   (S+1) first row of each segment, ascending, and the end of the last one; empty
///                 if there are no segments
/// \param sums     (S x C) row-major: the sums of segment s start at sums[s*C]
void segment_sums(std::span<const double* const> columns,
                  std::span<const std::size_t> begins,
                  double* sums);

/// The matrix X' W X of C columns, in one pass over the rows.
///
/// \param columns   (C) pointers to `rows` values each
/// \param weight    (rows) the diagonal of W, or null for ones
/// \param products  (C x C) sum_i w_i x_ij x_ik; both triangles are written
void weighted_products(std::span<const double* const> columns,
                       const double* weight,
                       std::size_t rows,
                       double* products);

}  // namespace silvafit::data
