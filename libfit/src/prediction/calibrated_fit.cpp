// SPDX-License-Identifier: MIT
#include "silvafit/fit/calibrated_fit.hpp"

#include <vector>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

void take_groups(const std::vector<std::string>& labels,
                 const MatrixXd& effects,
                 std::vector<std::string>& known_labels,
                 MatrixXd& known_effects) {
  std::vector<Index> known;
  known_labels.clear();
  for (Index g = 0; g < effects.cols(); ++g) {
    if (!effects.col(g).allFinite()) continue;
    known.push_back(g);
    known_labels.push_back(labels[static_cast<std::size_t>(g)]);
  }
  known_effects = effects(Eigen::all, known);
}

}  // namespace

FittedModel with_groups(const FittedModel& fit, const Calibration& calibration) {
  FittedModel result = fit;
  take_groups(
      calibration.group_labels, calibration.effects, result.group_labels, result.random_effects);
  if (fit.specification.outer_random) {
    take_groups(calibration.outer_labels,
                calibration.outer_effects,
                result.outer.labels,
                result.outer.effects);
  }
  result.uncertainty = {};
  result.outer_uncertainty = {};
  return result;
}

}  // namespace silvafit::fit
