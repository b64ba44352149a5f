// SPDX-License-Identifier: MIT
#include "result/estimated_terms.hpp"

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

}  // namespace silvafit::fit
