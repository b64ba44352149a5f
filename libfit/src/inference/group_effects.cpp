// SPDX-License-Identifier: MIT
#include "inference/group_effects.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd group_effects(const SurfaceSetting& setting) {
  const NonlinearModel& model = setting.model;
  MatrixXd effects = MatrixXd::Zero(model.coefficient_count(), model.group_count());
  const auto inner = model.coefficients_of(model.specification().random);
  for (std::size_t k = 0; k < inner.size(); ++k) {
    effects.row(inner[k]) += setting.fit.random_effects.row(static_cast<Index>(k));
  }
  const auto outer = model.coefficients_of(model.specification().outer_random);
  for (std::size_t k = 0; k < outer.size(); ++k) {
    for (Index c = 0; c < model.cluster_count(); ++c) {
      const Index begin = model.cluster_begin(c);
      effects.row(outer[k]).segment(begin, model.cluster_begin(c + 1) - begin).array() +=
          setting.fit.outer.effects(static_cast<Index>(k), c);
    }
  }
  return effects;
}

}  // namespace silvafit::fit
