// SPDX-License-Identifier: MIT
// The distribution of the random effects of groups before their data are used.
#pragma once

#include <utility>
#include <vector>

#include "model/small_matrix.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// How spherical random effects change the r coefficients that are random in some term: those of a
/// group change by joint * (u, v), with v its q effects of the last term and u the s effects of the
/// terms before it, which all groups of its cluster share.
struct RandomDesign {
  SmallMatrix joint{};  ///< (r x s + q)
  Index shared = 0;     ///< s

  Index own() const { return joint.cols() - shared; }  ///< q
};

/// The effects b of group g are offset_g + design_g z_g with independent standard normal effects
/// z_g of all terms. The designs and offsets must outlive this object.
class GroupPriors {
 public:
  /// The distribution of the model: the same design for all groups, without an offset.
  GroupPriors(const RandomDesign& design) : shared_(&design) {}  // NOLINT: also a prior
  /// \param designs  (G) all with the same number of effects
  /// \param offsets  (r x G)
  GroupPriors(std::vector<const RandomDesign*> designs, const MatrixXd& offsets)
      : designs_(std::move(designs)), offsets_(&offsets) {}

  bool is_shared() const { return shared_ != nullptr; }
  const RandomDesign& design(Index group) const {
    return is_shared() ? *shared_ : *designs_[static_cast<std::size_t>(group)];
  }
  /// Null where all are zero.
  const MatrixXd* offsets() const { return offsets_; }

 private:
  const RandomDesign* shared_ = nullptr;
  std::vector<const RandomDesign*> designs_;
  const MatrixXd* offsets_ = nullptr;
};

}  // namespace silvafit::fit
