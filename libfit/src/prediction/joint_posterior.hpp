// SPDX-License-Identifier: MIT
// The joint distribution of the random effects of several terms given the data.
#pragma once

#include <vector>

#include "conditional_modes/effect_factor.hpp"
#include "conditional_modes/effect_layout.hpp"
#include "conditional_modes/random_places.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The places of a fit's random effects among its coefficients.
RandomPlaces places_of(const FittedModel& fit);

/// Covariances between the effects of groups of different terms, from the factorized inverse
/// covariance matrix of all effects, which EffectCells describes.
class JointPosterior {
 public:
  /// \param labels  of the groups of each term, which the cells number
  JointPosterior(const FittedModel& fit,
                 const EffectCells& cells,
                 std::vector<std::vector<std::string>> labels);

  /// Of combinations of groups: one for each term, -1 where it is unknown.
  /// \returns (Q x Q) of each, Q effects of all terms: blocks of two different terms, zero for
  ///   unknown groups and within each term; NaN if the matrix is not positive definite
  std::vector<MatrixXd> between_terms(const std::vector<std::vector<Index>>& combinations) const;

 private:
  /// (effects of all groups x q) covariances with the effects of one group, before their roots.
  MatrixXd solved(std::size_t term, Index group) const;

  EffectLayout layout_;
  std::vector<MatrixXd> roots_;  ///< (q x q) of Psi of each term
  EffectFactor factor_;
  bool is_valid_ = false;
};

}  // namespace silvafit::fit
