// SPDX-License-Identifier: MIT
// Random effects of the clusters of consecutive rows, all at once.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "conditional_modes/arrow_factor.hpp"
#include "conditional_modes/calibration_search.hpp"

namespace silvafit::fit {

/// What all blocks of clusters share.
struct CalibrationSetting {
  const NonlinearModel& model;
  const EffectPriors& priors;
  const CalibrationTerms& terms;
  const EffectPlaces& places;
  std::vector<RandomDesign> designs{};
  Eigen::MatrixXd offsets{};   ///< (r x G) effects where z = 0
  bool is_linearized = false;  ///< conditional covariances are those of the linearized model
};

/// Finds the effects of the clusters [first, last), and what the data leave open of them.
/// \param is_known          whether the effects are given and not searched
/// \param effects           (r x G) of all groups, of which the block's own are read or found
/// \param held, own         (N) room for weights of all rows, if the terms hold weights
void calibrate_block(const CalibrationSetting& setting,
                     Eigen::Index first,
                     Eigen::Index last,
                     bool is_known,
                     Eigen::MatrixXd& effects,
                     Eigen::VectorXd& held,
                     Eigen::VectorXd& own,
                     EffectPosteriors& result);

}  // namespace silvafit::fit
