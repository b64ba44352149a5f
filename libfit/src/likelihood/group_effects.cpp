// SPDX-License-Identifier: MIT
#include "likelihood/group_effects.hpp"

#include "result/group_coefficients.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd group_effects(const SurfaceSetting& setting) {
  const NonlinearModel& model = setting.model;
  MatrixXd effects = MatrixXd::Zero(model.coefficient_count(), model.group_count());
  const ModelSpecification& specification = model.specification();
  add_group_effects(
      model,
      {.rows = model.coefficients_of(specification.random), .effects = setting.fit.random_effects},
      {.rows = model.coefficients_of(specification.outer_random),
       .effects = setting.fit.outer.effects},
      effects);
  return effects;
}

}  // namespace silvafit::fit
