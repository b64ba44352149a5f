// SPDX-License-Identifier: MIT
// The random effects of each group of a model's data, as additions to the coefficients.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// (q x labels) effects of the groups with these labels; zero if the label is not known.
Eigen::MatrixXd effects_by_label(const std::vector<std::string>& known_labels,
                                 const Eigen::MatrixXd& known_effects,
                                 const std::vector<std::string>& labels);

/// The random effects of one grouping.
struct GroupingEffects {
  const std::vector<Eigen::Index>& rows;  ///< (q) where they are added
  const Eigen::MatrixXd& effects;         ///< (q x groups); not read without rows
};

/// Adds to each group's column of a sum its random effects and those of the cluster that it is in.
/// \param sum  (p x G)
void add_group_effects(const NonlinearModel& model,
                       const GroupingEffects& inner,
                       const GroupingEffects& outer,
                       Eigen::MatrixXd& sum);

/// (p x G) coefficients of each group, random effects included.
Eigen::MatrixXd group_coefficients(const NonlinearModel& model, const MixedEffectsFit& fit);

/// (p x G) estimated effects of both groupings by the groups' labels; zero for groups that are not
/// in the fit.
Eigen::MatrixXd coefficient_effects(const FittedModel& fit, const NonlinearModel& model);

}  // namespace silvafit::fit
