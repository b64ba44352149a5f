// SPDX-License-Identifier: MIT
#include "likelihood/group_effects.hpp"

#include "model/nested_terms.hpp"
#include "result/group_coefficients.hpp"
#include "result/nested_effects.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd group_effects(const SurfaceSetting& setting) {
  const NonlinearModel& model = setting.model;
  MatrixXd effects = MatrixXd::Zero(model.coefficient_count(), model.group_count());
  const ModelSpecification& specification = model.specification();
  add_group_effects(model,
                    {.rows = model.coefficients_of(finer_term(specification)),
                     .effects = finer(setting.fit).effects},
                    {.rows = model.coefficients_of(coarser_term(specification)),
                     .effects = coarser(setting.fit).effects},
                    effects);
  return effects;
}

}  // namespace silvafit::fit
