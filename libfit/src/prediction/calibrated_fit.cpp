// SPDX-License-Identifier: MIT
#include "silvafit/fit/calibrated_fit.hpp"

#include <vector>

namespace silvafit::fit {

FittedModel with_groups(const FittedModel& fit, const Calibration& calibration) {
  FittedModel result = fit;
  for (std::size_t k = 0; k < result.random.size(); ++k) {
    const CalibratedEffects& found = calibration.random[k];
    EstimatedEffects& term = result.random[k];
    std::vector<Index> known;
    term.labels.clear();
    for (Index g = 0; g < found.effects.cols(); ++g) {
      if (!found.effects.col(g).allFinite()) continue;
      known.push_back(g);
      term.labels.push_back(found.labels[static_cast<std::size_t>(g)]);
    }
    term.effects = found.effects(Eigen::all, known);
    term.uncertainty = {};
  }
  result.cells = {};
  return result;
}

}  // namespace silvafit::fit
