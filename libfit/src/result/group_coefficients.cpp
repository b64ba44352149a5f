// SPDX-License-Identifier: MIT
#include "result/group_coefficients.hpp"

#include <string>
#include <vector>

#include "model/group_labels.hpp"
#include "model/nested_terms.hpp"
#include "result/nested_effects.hpp"

namespace silvafit::fit {
using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd effects_by_label(const std::vector<std::string>& known_labels,
                          const MatrixXd& known_effects,
                          const std::vector<std::string>& labels) {
  const LabelNumbers known = numbered(known_labels);
  MatrixXd result = MatrixXd::Zero(known_effects.rows(), static_cast<Index>(labels.size()));
  for (std::size_t g = 0; g < labels.size(); ++g) {
    const auto found = known.find(labels[g]);
    if (found == known.end()) continue;
    result.col(static_cast<Index>(g)) = known_effects.col(found->second);
  }
  return result;
}

void add_group_effects(const NonlinearModel& model,
                       const GroupingEffects& inner,
                       const GroupingEffects& outer,
                       MatrixXd& sum) {
  if (!inner.rows.empty()) sum(inner.rows, Eigen::all) += inner.effects;
  if (outer.rows.empty()) return;
  for (Index c = 0; c < model.cluster_count(); ++c) {
    for (Index g = model.cluster_begin(c); g < model.cluster_begin(c + 1); ++g) {
      sum(outer.rows, g) += outer.effects.col(c);
    }
  }
}

MatrixXd group_coefficients(const NonlinearModel& model, const MixedEffectsFit& fit) {
  const ModelSpecification& specification = model.specification();
  MatrixXd result = fit.estimate.replicate(1, model.group_count());
  add_group_effects(
      model,
      {.rows = model.coefficients_of(finer_term(specification)), .effects = finer(fit).effects},
      {.rows = model.coefficients_of(coarser_term(specification)), .effects = coarser(fit).effects},
      result);
  return result;
}

MatrixXd coefficient_effects(const FittedModel& fit, const NonlinearModel& model) {
  MatrixXd result = MatrixXd::Zero(model.coefficient_count(), model.group_count());
  if (!fit.has_random_effects()) return result;
  const auto by_label = [](const EstimatedEffects& term, const std::vector<std::string>& labels) {
    return effects_by_label(term.labels, term.effects, labels);
  };
  add_group_effects(model,
                    {.rows = model.coefficients_of(finer_term(fit.specification)),
                     .effects = by_label(finer(fit), model.group_labels())},
                    {.rows = model.coefficients_of(coarser_term(fit.specification)),
                     .effects = by_label(coarser(fit), model.outer_labels())},
                    result);
  return result;
}

}  // namespace silvafit::fit
