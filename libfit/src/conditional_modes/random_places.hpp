// SPDX-License-Identifier: MIT
// The coefficients that have random effects.
#pragma once

#include <vector>

#include "model/small_matrix.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The coefficients with random effects in each term, and their places among the r coefficients
/// that have them in any term.
struct RandomPlaces {
  std::vector<std::vector<Index>> terms{};  ///< (q) coefficients of each term
  std::vector<Index> all{};                 ///< (r) of all terms, ascending
  std::vector<std::vector<Index>> rows{};   ///< (q) places of each term in `all`

  explicit RandomPlaces(const NonlinearModel& model) : RandomPlaces(model.random_coefficients()) {}
  explicit RandomPlaces(std::vector<std::vector<Index>> of_terms);
  Index r() const { return static_cast<Index>(all.size()); }
  /// Number of effects of a term.
  Index q(std::size_t term) const { return static_cast<Index>(terms[term].size()); }
  /// A matrix of random effects for each term, zero.
  std::vector<MatrixXd> no_effects(const NonlinearModel& model) const;
  /// (r x all effects of a group) how independent effects of all terms change the coefficients.
  /// \param factors  (q x q) of each term
  SmallMatrix joint(const std::vector<MatrixXd>& factors) const;
};

/// Adds the rows of a factor where its effects are among the random coefficients.
/// \param rows    of `sum`, one for each row of the factor
/// \param column  of `sum` to which the first column of the factor is added
void add_placed(const MatrixXd& factor,
                const std::vector<Index>& rows,
                Index column,
                SmallMatrix& sum);

}  // namespace silvafit::fit
