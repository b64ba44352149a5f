// SPDX-License-Identifier: MIT
// Cells whose data are known by the curvature of their density only.
#pragma once

#include "conditional_modes/observation_sums.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The sums of cells of earlier data, followed by those of the cells of a model. The density of an
/// earlier cell is quadratic around the effects that these data gave, without a slope: the earlier
/// modes are the means of the prior, of which only deviations are sought.
class StoredCells : public DensitySums {
 public:
  /// \param curvatures  (triangle x earlier cells)
  /// \param centers     (r x earlier cells) effects of the earlier data
  /// \param sums        of the model; outlives this object
  StoredCells(const MatrixXd& curvatures, MatrixXd centers, const DensitySums& sums);

  Index row_begin(Index cell) const override;
  void density(Index first,
               Index last,
               const MatrixXd& effects,
               MatrixXd& sums,
               Workspace& workspace,
               HeldWeights* weights) const override;
  void mixed(Index first,
             Index last,
             const MatrixXd& effects,
             MatrixXd& sums,
             Workspace& workspace) const override;

 private:
  Index stored() const { return curvatures_.cols(); }

  const MatrixXd& curvatures_;
  MatrixXd centers_;
  const DensitySums& sums_;
};

}  // namespace silvafit::fit
