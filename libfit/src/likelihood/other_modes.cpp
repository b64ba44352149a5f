// SPDX-License-Identifier: MIT
#include "likelihood/other_modes.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool take_lower(const NonlinearModel& model,
                const Modes& others,
                const VectorXd& of_others,
                Modes& modes,
                VectorXd& objectives) {
  constexpr double kLower = 1e-6;
  bool any = false;
  for (Index c = 0; c < objectives.size(); ++c) {
    if (!(of_others[c] < objectives[c] - kLower)) continue;
    const Index first = model.cluster_begin(c);
    const Index count = model.cluster_begin(c + 1) - first;
    modes.inner.middleCols(first, count) = others.inner.middleCols(first, count);
    if (modes.outer.rows() > 0) modes.outer.col(c) = others.outer.col(c);
    objectives[c] = of_others[c];
    any = true;
  }
  return any;
}

std::vector<Modes> other_starts(const Modes& modes) {
  const Modes none{.outer = MatrixXd::Zero(modes.outer.rows(), modes.outer.cols()),
                   .inner = MatrixXd::Zero(modes.inner.rows(), modes.inner.cols())};
  std::vector<Modes> starts{none};
  // Standard deviations.
  for (const double side : {2.0, -2.0, 1.0, -1.0}) {
    for (Index k = 0; k < modes.inner.rows(); ++k) {
      starts.push_back(none);
      starts.back().inner.row(k).setConstant(side);
    }
    for (Index k = 0; k < modes.outer.rows(); ++k) {
      starts.push_back(none);
      starts.back().outer.row(k).setConstant(side);
    }
  }
  return starts;
}

}  // namespace silvafit::fit
