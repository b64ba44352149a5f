// SPDX-License-Identifier: MIT
#include "result/estimated_terms.hpp"

#include "silvafit/base/constants.hpp"

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

std::vector<EstimatedEffects> missing_terms(const NonlinearModel& model) {
  Estimates result;
  name_terms(model, result);
  for (EstimatedEffects& term : result.random) {
    const auto q = static_cast<Index>(term.names.size());
    term.covariance = MatrixXd::Constant(q, q, kNaN);
    term.effects = MatrixXd::Constant(q, static_cast<Index>(term.labels.size()), kNaN);
  }
  return result.random;
}

}  // namespace silvafit::fit
