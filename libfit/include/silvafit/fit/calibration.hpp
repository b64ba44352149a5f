// SPDX-License-Identifier: MIT
// Random effects of the groups of a table from its measured trees, without a refit.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/effect_uncertainty.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Random effects of a group that was in the fit.
enum class SeenGroups {
  /// The fit's own random effects. Its trees in the table are assumed to be those of the fit, and
  /// are not used a second time.
  kFitted,
  /// Only the trees of the table, as if the group were not in the fit.
  kNew,
  /// Both: the trees of the table are further ones, and the fit's random effects with their
  /// conditional covariance represent the earlier trees.
  kCombined,
};
constexpr std::array<std::string_view, 3> words_of(SeenGroups /*groups*/) {
  return {"fitted", "new", "combined"};
}

struct CalibrationOptions {
  SeenGroups seen_groups = SeenGroups::kFitted;
  unsigned threads = 1;
};

/// The random effects of one term for a table: G groups in the order of their first appearance,
/// with several terms then those of the fit that the table does not have, unless groups are new; N
/// rows, p coefficients, q random effects in the order of the fit's. Values of a group whose mode
/// was not found are NaN.
struct CalibratedEffects {
  std::vector<std::string> labels{};         ///< (G) as in EstimatedEffects
  std::vector<Eigen::Index> group_of_row{};  ///< (N) -1 if the group is missing
  std::vector<Eigen::Index> fitted_group{};  ///< (G) its number in the fit, -1 if not seen
  std::vector<Eigen::Index> measured{};      ///< (G) trees of the table that were used
  Eigen::MatrixXd effects{};                 ///< (q x G) EBLUPs
  EffectUncertainty uncertainty{};           ///< of effects
};

/// The random effects of all groups of a table given its measured trees, at a fit's estimates.
struct Calibration {
  std::vector<CalibratedEffects> random{};  ///< the terms of the fit, in their order
  EffectCells cells{};                      ///< of several terms, by the groups above
  /// (N) whether the row's response was used.
  std::vector<bool> is_used{};
};

/// The EBLUPs of every group of a table, from the rows with response and predictors.
///
/// Coefficients, covariances and variance parameters are those of the fit. Random effects have the
/// same definition as in the fit: for lb the solution of penalized least squares with weights at
/// its fitted values, for the methods of marginal likelihood the mode of the random effects'
/// density. For the data of the fit, SeenGroups::kNew returns the fit's own
/// EBLUPs. Conditional covariances are those of the linearized model for lb and the inverse
/// curvature of the density for the other methods. A group without a measured tree has effects
/// zero with covariance Psi. With several terms the effects of all groups are estimated together,
/// from the curvatures of the fit's cells and the trees of the table; a tree whose groups are all
/// in the fit is assumed to be one of the fit. Psi may be singular. The result does not depend on
/// the number of threads. \throws UsageError if the fit has no random effects or no estimates, if
/// the column of groups or
///   one that the model needs is missing, if SeenGroups needs conditional covariances that the fit
///   (of an older file) does not have, or if groups are combined with correlated residuals
/// Source: Lindstrom and Bates 1990, Biometrics 46, 673-687; Lappi 1991; docs/prediction.md.
Calibration calibrate(const FittedModel& fit,
                      const data::Table& table,
                      const CalibrationOptions& options = {});

}  // namespace silvafit::fit
