// SPDX-License-Identifier: MIT
#include "conditional_modes/stored_cells.hpp"

#include <algorithm>
#include <utility>

#include "model/small_matrix.hpp"

namespace silvafit::fit {

StoredCells::StoredCells(const MatrixXd& curvatures, MatrixXd centers, const DensitySums& sums)
    : DensitySums(sums.random()),
      curvatures_(curvatures),
      centers_(std::move(centers)),
      sums_(sums) {
  has_approximation_ = sums.has_approximation();
  holds_weights_ = sums.holds_weights();
  has_kinks_ = sums.has_kinks();
  others_ = sums.others();
}

Index StoredCells::row_begin(Index cell) const {
  return sums_.row_begin(std::max<Index>(cell - stored(), 0));
}

void StoredCells::density(Index first,
                          Index last,
                          const MatrixXd& effects,
                          MatrixXd& sums,
                          Workspace& workspace,
                          HeldWeights* weights) const {
  MatrixXd of_model;
  const Index from = std::max(first, stored());
  if (from < last) {
    sums_.density(from - stored(),
                  last - stored(),
                  effects.rightCols(effects.cols() - stored()),
                  of_model,
                  workspace,
                  weights);
  }
  sums.resize(density_count(), last - first);
  sums.rightCols(of_model.cols()) = of_model;
  const Index r = random_count();
  const Index triangle = curvatures_.rows();
  for (Index cell = first; cell < std::min(last, stored()); ++cell) {
    const SmallVector change = effects.col(cell) - centers_.col(cell);
    const SmallVector slope = unpacked(curvatures_.col(cell).data(), r) * change;
    auto column = sums.col(cell - first);
    column[0] = 0.5 * change.dot(slope);
    column.segment(1, r) = slope;
    column.segment(1 + r, triangle) = curvatures_.col(cell);
    if (has_approximation()) column.segment(1 + r + triangle, triangle) = curvatures_.col(cell);
    if (holds_weights()) column.tail(1) = column.head(1);
  }
}

void StoredCells::mixed(
    Index first, Index last, const MatrixXd& effects, MatrixXd& sums, Workspace& workspace) const {
  MatrixXd of_model;
  const Index from = std::max(first, stored());
  if (from < last) {
    sums_.mixed(from - stored(),
                last - stored(),
                effects.rightCols(effects.cols() - stored()),
                of_model,
                workspace);
  }
  sums.setZero(std::ssize(others()) * random_count(), last - first);
  sums.rightCols(of_model.cols()).topRows(of_model.rows()) = of_model;
}

}  // namespace silvafit::fit
