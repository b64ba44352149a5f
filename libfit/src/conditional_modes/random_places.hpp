// SPDX-License-Identifier: MIT
// The coefficients that have random effects.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/small_matrix.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The coefficients with random effects, and their places among all of these: s effects of the
/// coarser grouping, q of the only or the finer one, r coefficients in either.
struct RandomPlaces {
  std::vector<Eigen::Index> outer{};       ///< (s) coefficients
  std::vector<Eigen::Index> inner{};       ///< (q)
  std::vector<Eigen::Index> all{};         ///< (r) of both, ascending
  std::vector<Eigen::Index> outer_rows{};  ///< (s) rows among the random coefficients
  std::vector<Eigen::Index> inner_rows{};  ///< (q)

  explicit RandomPlaces(const NonlinearModel& model);
  Eigen::Index r() const { return static_cast<Eigen::Index>(all.size()); }
  Eigen::Index s() const { return static_cast<Eigen::Index>(outer.size()); }
  Eigen::Index q() const { return static_cast<Eigen::Index>(inner.size()); }
};

/// Adds the rows of a factor where its effects are among the random coefficients.
/// \param rows  of `sum`, one for each row of the factor
void add_placed(const Eigen::MatrixXd& factor,
                const std::vector<Eigen::Index>& rows,
                SmallMatrix& sum);

}  // namespace silvafit::fit
