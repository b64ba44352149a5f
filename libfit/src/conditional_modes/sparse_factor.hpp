// SPDX-License-Identifier: MIT
// The factorized Hessian of the random effects of one cluster of crossed groups.
#pragma once

#include <vector>

#include "model/small_matrix.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Where the Hessian of n random effects and its Cholesky factor differ from zero, after a
/// minimum-degree ordering. The last columns, which fill up with crossed groups, are stored as a
/// dense matrix, for which the factorization of Eigen is many times faster.
///
/// Numbers of a matrix with this pattern are those of the sparse columns, each from its diagonal
/// on, then the dense matrix by columns.
class SparsePattern {
 public:
  /// \param of_cells  (Q x cells) places of the effects that act on each cell, distinct
  /// \throws UsageError if the factor would have more than 5e8 numbers
  SparsePattern(Index size, Eigen::MatrixXi of_cells);

  Index size() const { return size_; }
  Index cells() const { return of_cells_.cols(); }
  /// Place of an effect of a cell.
  Index place(Index effect, Index cell) const { return of_cells_(effect, cell); }

 private:
  friend class SparseFactor;

  void order();
  void find_columns();
  void place_cells();
  /// Position among the stored numbers; row and column are pivots, row >= column.
  int position(int row, int column) const;
  int columns() const { return static_cast<int>(begin_.size()) - 1; }
  int dense() const { return static_cast<int>(size_) - columns(); }

  Index size_ = 0;
  Eigen::MatrixXi of_cells_;
  std::vector<int> pivot_;        ///< (n) of each place
  std::vector<int> begin_;        ///< (sparse columns + 1) first number of each
  std::vector<int> rows_;         ///< of each number of sparse columns, ascending
  std::vector<int> dense_begin_;  ///< (sparse columns) first number in a dense row
  std::vector<int> row_begin_;    ///< (sparse columns + 1) first of each row's numbers
  std::vector<int> row_columns_;  ///< column of each number before the diagonal, by row
  std::vector<int> row_numbers_;  ///< position of the same
  Eigen::MatrixXi of_pairs_;      ///< (Q (Q + 1) / 2 x cells) positions, lower triangles by columns
};

/// The Cholesky factor L L' of a sparse Hessian, and the elements of its inverse within the pattern
/// by the recurrence of Takahashi.
/// Sources: Davis 2006, Direct Methods for Sparse Linear Systems, chapters 4 and 7; Takahashi,
/// Fagan and Chen 1973.
class SparseFactor {
 public:
  /// Sets the matrix to a multiple of the identity.
  void begin(const SparsePattern& pattern, double diagonal);
  /// Adds a matrix for the effects of a cell.
  void add(Index cell, const SmallMatrix& block);
  /// \returns false if the matrix is not positive definite
  bool factorize();

  double log_determinant() const;
  /// See ArrowFactor.
  double smallest_pivot() const { return smallest_pivot_; }
  /// Solves H z = right side, in place.
  void solve(Eigen::Ref<VectorXd> z) const;
  /// Computes the inverse of the factorized matrix, for inverse_block().
  void invert();
  /// The block of the inverse of a cell's effects.
  SmallMatrix inverse_block(Index cell) const;

 private:
  using Dense = Eigen::Map<MatrixXd>;
  using ConstDense = Eigen::Map<const MatrixXd>;
  Dense dense(std::vector<double>& of) const {
    const int size = pattern_->dense();
    return {of.data() + pattern_->begin_.back(), size, size};
  }
  ConstDense dense(const std::vector<double>& of) const {
    const int size = pattern_->dense();
    return {of.data() + pattern_->begin_.back(), size, size};
  }
  bool factorize_columns();
  void reduce_dense();
  void invert_column(int column);

  const SparsePattern* pattern_ = nullptr;
  std::vector<double> factor_;
  std::vector<double> inverse_;
  std::vector<double> work_;  ///< (n) zeros between uses
  double smallest_pivot_ = 0.0;
};

}  // namespace silvafit::fit
