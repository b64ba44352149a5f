// SPDX-License-Identifier: MIT
#include "result/group_coefficients.hpp"

#include <string>
#include <vector>

#include "model/group_labels.hpp"
#include "model/model_groups.hpp"

namespace silvafit::fit {

std::vector<MatrixXd> effects_of(const Estimates& estimates) {
  std::vector<MatrixXd> result;
  for (const EstimatedEffects& term : estimates.random) result.push_back(term.effects);
  return result;
}

std::vector<MatrixXd> covariances_of(const Estimates& estimates) {
  std::vector<MatrixXd> result;
  for (const EstimatedEffects& term : estimates.random) result.push_back(term.covariance);
  return result;
}

void name_terms(const NonlinearModel& model, Estimates& estimates) {
  const std::vector<RandomEffects>& terms = model.specification().random;
  estimates.random.resize(terms.size());
  for (std::size_t k = 0; k < terms.size(); ++k) {
    estimates.random[k].names = terms[k].coefficients;
    estimates.random[k].labels = model.group_labels(k);
  }
}

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

void add_group_effects(const ModelGroups& groups,
                       const std::vector<std::vector<Index>>& rows,
                       const std::vector<MatrixXd>& effects,
                       MatrixXd& sum) {
  for (std::size_t t = rows.size(); t-- > 0;) {
    for (Index g = 0; g < sum.cols(); ++g) {
      Index row = 0;
      for (const Index place : rows[t]) sum(place, g) += effects[t](row++, groups.group_of(t, g));
    }
  }
}

MatrixXd group_coefficients(const NonlinearModel& model, const MixedEffectsFit& fit) {
  MatrixXd result = model.extended(fit.estimate).replicate(1, model.group_count());
  add_group_effects(model.groups(), model.random_coefficients(), effects_of(fit), result);
  return result;
}

MatrixXd coefficient_effects(const FittedModel& fit, const NonlinearModel& model) {
  MatrixXd result = MatrixXd::Zero(model.column_count(), model.group_count());
  std::vector<MatrixXd> by_label;
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    const EstimatedEffects& term = fit.random[t];
    by_label.push_back(effects_by_label(term.labels, term.effects, model.group_labels(t)));
  }
  add_group_effects(model.groups(), model.random_coefficients(), by_label, result);
  return result;
}

}  // namespace silvafit::fit
