// SPDX-License-Identifier: MIT
// The random effects of each group of a model's data, as additions to the coefficients.
#pragma once

#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// (q x groups) the effects of each term.
std::vector<MatrixXd> effects_of(const Estimates& estimates);
/// (q x q) the covariance Psi of each term.
std::vector<MatrixXd> covariances_of(const Estimates& estimates);

/// Sets names and labels of a model's terms. Values are unchanged.
void name_terms(const NonlinearModel& model, Estimates& estimates);

/// (q x labels) effects of the groups with these labels; zero if the label is not known.
MatrixXd effects_by_label(const std::vector<std::string>& known_labels,
                          const MatrixXd& known_effects,
                          const std::vector<std::string>& labels);

/// Adds to each group's column of a sum the random effects of all terms.
/// \param rows     (q) of each term: where its effects are added
/// \param effects  (q x groups) of each term
/// \param sum      (p x G)
void add_group_effects(const ModelGroups& groups,
                       const std::vector<std::vector<Index>>& rows,
                       const std::vector<MatrixXd>& effects,
                       MatrixXd& sum);

/// (columns x G) coefficients of each group, random effects included; also those with random
/// effects only.
MatrixXd group_coefficients(const NonlinearModel& model, const MixedEffectsFit& fit);

/// (columns x G) estimated effects of all terms by the groups' labels; zero for groups that are not
/// in the fit.
MatrixXd coefficient_effects(const FittedModel& fit, const NonlinearModel& model);

}  // namespace silvafit::fit
