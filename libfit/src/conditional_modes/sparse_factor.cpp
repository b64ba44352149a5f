// SPDX-License-Identifier: MIT
#include "conditional_modes/sparse_factor.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

// Share of numbers that differ from zero from which the last columns are stored as a dense matrix.
constexpr double kDense = 0.5;
// Numbers of a factor: 4 GB, and as many again for the inverse.
constexpr double kMostNumbers = 5e8;
// Size up to which a triangle is inverted at once; halves of larger ones are products of matrices.
constexpr Index kSmallTriangle = 64;

/// Overwrites the lower triangle L of a matrix by that of its inverse.
void invert_triangle(Eigen::Ref<MatrixXd> matrix) {
  const Index n = matrix.rows();
  auto lower = matrix.triangularView<Eigen::Lower>();
  if (n <= kSmallTriangle) {
    const MatrixXd inverse = lower.solve(MatrixXd::Identity(n, n));
    lower = inverse;
    return;
  }
  const Index half = n / 2;
  invert_triangle(matrix.topLeftCorner(half, half));
  invert_triangle(matrix.bottomRightCorner(n - half, n - half));
  const MatrixXd product = matrix.bottomLeftCorner(n - half, half) *
                           matrix.topLeftCorner(half, half).triangularView<Eigen::Lower>();
  matrix.bottomLeftCorner(n - half, half) =
      matrix.bottomRightCorner(n - half, n - half).triangularView<Eigen::Lower>() * -product;
}

/// Overwrites the lower triangle W of a matrix by that of W'W.
void square_triangle(Eigen::Ref<MatrixXd> matrix) {
  const Index n = matrix.rows();
  if (n <= kSmallTriangle) {
    const MatrixXd lower = matrix.triangularView<Eigen::Lower>();
    matrix.triangularView<Eigen::Lower>() = lower.transpose() * lower;
    return;
  }
  const Index half = n / 2;
  square_triangle(matrix.topLeftCorner(half, half));
  auto below = matrix.bottomLeftCorner(n - half, half);
  matrix.topLeftCorner(half, half).selfadjointView<Eigen::Lower>().rankUpdate(below.transpose());
  const MatrixXd product =
      matrix.bottomRightCorner(n - half, n - half).triangularView<Eigen::Lower>().transpose() *
      below;
  below = product;
  square_triangle(matrix.bottomRightCorner(n - half, n - half));
}

}  // namespace

SparsePattern::SparsePattern(Index size, Eigen::MatrixXi of_cells)
    : size_(size), of_cells_(std::move(of_cells)) {
  order();
  find_columns();
  place_cells();
}

void SparsePattern::order() {
  std::vector<Eigen::Triplet<double>> entries;
  for (Index k = 0; k < cells(); ++k) {
    for (Index a = 0; a < of_cells_.rows(); ++a) {
      for (Index b = 0; b < of_cells_.rows(); ++b) {
        entries.emplace_back(of_cells_(a, k), of_cells_(b, k), 1.0);
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(size_, size_);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(matrix, order);
  // The ordering lists the places by pivot.
  pivot_.resize(static_cast<std::size_t>(size_));
  for (int k = 0; k < static_cast<int>(size_); ++k) {
    pivot_[static_cast<std::size_t>(order.indices()[k])] = k;
  }
}

/// The pattern of each column of the factor: its own and those of its children in the elimination
/// tree.
void SparsePattern::find_columns() {
  const auto n = static_cast<std::size_t>(size_);
  std::vector<std::vector<int>> below(n);  // rows below the diagonal
  for (Index k = 0; k < cells(); ++k) {
    for (Index a = 0; a < of_cells_.rows(); ++a) {
      const int row = pivot_[static_cast<std::size_t>(of_cells_(a, k))];
      for (Index b = 0; b < of_cells_.rows(); ++b) {
        const int column = pivot_[static_cast<std::size_t>(of_cells_(b, k))];
        if (row > column) below[static_cast<std::size_t>(column)].push_back(row);
      }
    }
  }
  double stored = 0.0;
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<int>& rows = below[j];
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    stored += static_cast<double>(rows.size()) / kDense;
    if (stored > kMostNumbers) {
      throw UsageError(fmt::format(
          "the {} crossed random effects are connected to so many others that their Cholesky "
          "factor has more than {:.0e} numbers; use fewer groups or fewer random effects",
          size_,
          kMostNumbers));
    }
    if (rows.size() < 2) continue;
    std::vector<int>& parent = below[static_cast<std::size_t>(rows.front())];
    parent.insert(parent.end(), rows.begin() + 1, rows.end());
  }
  std::size_t sparse = n;
  double filled = 0.0;
  for (std::size_t j = n; j-- > 0;) {
    filled += 1.0 + static_cast<double>(below[j].size());
    const auto left = static_cast<double>(n - j);
    if (filled >= kDense * 0.5 * left * (left + 1.0)) sparse = j;
  }
  begin_.assign(1, 0);
  for (std::size_t j = 0; j < sparse; ++j) {
    const auto first_dense = std::ranges::lower_bound(below[j], static_cast<int>(sparse));
    rows_.push_back(static_cast<int>(j));
    dense_begin_.push_back(begin_.back() + 1 + static_cast<int>(first_dense - below[j].begin()));
    rows_.insert(rows_.end(), below[j].begin(), below[j].end());
    begin_.push_back(static_cast<int>(rows_.size()));
  }
  std::vector<std::vector<std::pair<int, int>>> left(sparse);  // column and position, by row
  for (std::size_t j = 0; j < sparse; ++j) {
    for (int at = begin_[j] + 1; at < dense_begin_[j]; ++at) {
      left[static_cast<std::size_t>(rows_[static_cast<std::size_t>(at)])].emplace_back(j, at);
    }
  }
  row_begin_.assign(1, 0);
  for (const auto& row : left) {
    for (const auto& [column, at] : row) {
      row_columns_.push_back(column);
      row_numbers_.push_back(at);
    }
    row_begin_.push_back(static_cast<int>(row_columns_.size()));
  }
}

int SparsePattern::position(int row, int column) const {
  if (column >= columns()) {
    return begin_.back() + (column - columns()) * dense() + (row - columns());
  }
  const auto begin = rows_.begin() + begin_[static_cast<std::size_t>(column)];
  const auto end = rows_.begin() + begin_[static_cast<std::size_t>(column) + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - rows_.begin());
}

void SparsePattern::place_cells() {
  const Index q = of_cells_.rows();
  of_pairs_.resize(q * (q + 1) / 2, cells());
  for (Index k = 0; k < cells(); ++k) {
    Index pair = 0;
    for (Index b = 0; b < q; ++b) {
      for (Index a = b; a < q; ++a) {
        const auto [low, high] = std::minmax({pivot_[static_cast<std::size_t>(of_cells_(a, k))],
                                              pivot_[static_cast<std::size_t>(of_cells_(b, k))]});
        of_pairs_(pair++, k) = position(high, low);
      }
    }
  }
}

void SparseFactor::begin(const SparsePattern& pattern, double diagonal) {
  pattern_ = &pattern;
  const auto dense_size = static_cast<std::size_t>(pattern.dense());
  factor_.assign(static_cast<std::size_t>(pattern.begin_.back()) + dense_size * dense_size, 0.0);
  work_.assign(static_cast<std::size_t>(pattern.size()), 0.0);
  for (int j = 0; j < pattern.columns(); ++j) factor_[pattern.begin_[j]] = diagonal;
  dense(factor_).diagonal().setConstant(diagonal);
}

void SparseFactor::add(Index cell, const SmallMatrix& block) {
  const int* position = pattern_->of_pairs_.col(cell).data();
  for (Index b = 0; b < block.cols(); ++b) {
    for (Index a = b; a < block.rows(); ++a) factor_[*position++] += block(a, b);
  }
}

bool SparseFactor::factorize() {
  smallest_pivot_ = kInfinity;
  if (!factorize_columns()) return false;
  reduce_dense();
  Dense last = dense(factor_);
  if (last.size() == 0) return true;
  const Eigen::LLT<Eigen::Ref<MatrixXd>> cholesky(last);
  if (cholesky.info() != Eigen::Success || !last.diagonal().allFinite()) return false;
  const double root = last.diagonal().minCoeff();
  smallest_pivot_ = std::min(smallest_pivot_, root * root);
  return true;
}

/// Column by column: what the columns before it contribute is summed in the work vector.
bool SparseFactor::factorize_columns() {
  const SparsePattern& of = *pattern_;
  for (int j = 0; j < of.columns(); ++j) {
    const int begin = of.begin_[j];
    const int end = of.begin_[j + 1];
    for (int k = of.row_begin_[j]; k < of.row_begin_[j + 1]; ++k) {
      const int column = of.row_columns_[k];
      const int first = of.row_numbers_[k];
      const double factor = factor_[first];
      for (int at = first; at < of.begin_[column + 1]; ++at) {
        work_[of.rows_[at]] += factor * factor_[at];
      }
    }
    const double pivot = factor_[begin] - std::exchange(work_[j], 0.0);
    const bool is_positive = pivot > 0.0 && std::isfinite(pivot);
    smallest_pivot_ = std::min(smallest_pivot_, pivot);
    const double root = std::sqrt(pivot);
    factor_[begin] = root;
    for (int at = begin + 1; at < end; ++at) {
      factor_[at] = (factor_[at] - std::exchange(work_[of.rows_[at]], 0.0)) / root;
    }
    if (!is_positive) return false;
  }
  return true;
}

/// Subtracts what the sparse columns contribute to the dense matrix.
void SparseFactor::reduce_dense() {
  const SparsePattern& of = *pattern_;
  Dense last = dense(factor_);
  const int first_row = of.columns();
  for (int j = 0; j < of.columns(); ++j) {
    const int end = of.begin_[j + 1];
    for (int b = of.dense_begin_[j]; b < end; ++b) {
      double* const column = last.col(of.rows_[b] - first_row).data() - first_row;
      const double factor = factor_[b];
      for (int a = b; a < end; ++a) column[of.rows_[a]] -= factor * factor_[a];
    }
  }
}

double SparseFactor::log_determinant() const {
  double sum = 0.0;
  for (int j = 0; j < pattern_->columns(); ++j) sum += std::log(factor_[pattern_->begin_[j]]);
  sum += dense(factor_).diagonal().array().log().sum();
  return 2.0 * sum;
}

void SparseFactor::solve(Eigen::Ref<VectorXd> z) const {
  const SparsePattern& of = *pattern_;
  VectorXd x(z.size());
  for (Index k = 0; k < x.size(); ++k) x[of.pivot_[static_cast<std::size_t>(k)]] = z[k];
  for (int j = 0; j < of.columns(); ++j) {
    x[j] /= factor_[of.begin_[j]];
    for (int at = of.begin_[j] + 1; at < of.begin_[j + 1]; ++at) {
      x[of.rows_[at]] -= factor_[at] * x[j];
    }
  }
  const ConstDense last = dense(factor_);
  if (last.size() > 0) {
    auto tail = x.tail(last.rows());
    last.triangularView<Eigen::Lower>().solveInPlace(tail);
    last.triangularView<Eigen::Lower>().transpose().solveInPlace(tail);
  }
  for (int j = of.columns(); j-- > 0;) {
    for (int at = of.begin_[j] + 1; at < of.begin_[j + 1]; ++at) {
      x[j] -= factor_[at] * x[of.rows_[at]];
    }
    x[j] /= factor_[of.begin_[j]];
  }
  for (Index k = 0; k < x.size(); ++k) z[k] = x[of.pivot_[static_cast<std::size_t>(k)]];
}

void SparseFactor::invert() {
  inverse_.resize(factor_.size());
  Dense last = dense(inverse_);
  if (last.size() > 0) {
    last = dense(std::as_const(factor_));
    invert_triangle(last);
    square_triangle(last);
  }
  for (int j = pattern_->columns(); j-- > 0;) invert_column(j);
}

/// With l the column of the factor below its diagonal d, and Z the inverse: z = -Z l / d for the
/// rows of l, and 1/d^2 - l'z/d on the diagonal.
void SparseFactor::invert_column(int j) {
  const SparsePattern& of = *pattern_;
  const int begin = of.begin_[j];
  const int end = of.begin_[j + 1];
  const double root = factor_[begin];
  for (int at = begin + 1; at < end; ++at) work_[of.rows_[at]] = 0.0;
  const int first_row = of.columns();
  const ConstDense last = dense(std::as_const(inverse_));
  for (int b = begin + 1; b < end; ++b) {
    const int column = of.rows_[b];
    const double factor = factor_[b];
    double sum = 0.0;  // of the products with the column below its diagonal
    if (b >= of.dense_begin_[j]) {
      const double* const numbers = last.col(column - first_row).data() - first_row;
      work_[column] += numbers[column] * factor;
      for (int a = b + 1; a < end; ++a) {
        work_[of.rows_[a]] += numbers[of.rows_[a]] * factor;
        sum += numbers[of.rows_[a]] * factor_[a];
      }
    } else {
      // The rows below are among those of the column.
      int number = of.begin_[column];
      work_[column] += inverse_[number] * factor;
      for (int a = b + 1; a < end; ++a) {
        while (of.rows_[number] < of.rows_[a]) ++number;
        work_[of.rows_[a]] += inverse_[number] * factor;
        sum += inverse_[number] * factor_[a];
      }
    }
    work_[column] += sum;
  }
  double along = 0.0;
  for (int at = begin + 1; at < end; ++at) {
    inverse_[at] = -std::exchange(work_[of.rows_[at]], 0.0) / root;
    along += factor_[at] * inverse_[at];
  }
  inverse_[begin] = 1.0 / (root * root) - along / root;
}

SmallMatrix SparseFactor::inverse_block(Index cell) const {
  const Index q = pattern_->of_cells_.rows();
  SmallMatrix result(q, q);
  const int* position = pattern_->of_pairs_.col(cell).data();
  for (Index b = 0; b < q; ++b) {
    for (Index a = b; a < q; ++a) result(a, b) = result(b, a) = inverse_[*position++];
  }
  return result;
}

}  // namespace silvafit::fit
