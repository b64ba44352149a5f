// SPDX-License-Identifier: MIT
#include "result/nested_effects.hpp"

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

const EstimatedEffects& no_effects() {
  static const EstimatedEffects none;
  return none;
}

}  // namespace

const EstimatedEffects& finer(const Estimates& estimates) {
  return estimates.random.empty() ? no_effects() : estimates.random.back();
}

const EstimatedEffects& coarser(const Estimates& estimates) {
  return estimates.random.size() < 2 ? no_effects() : estimates.random.front();
}

void name_terms(const NonlinearModel& model, Estimates& estimates) {
  const std::vector<RandomEffects>& terms = model.specification().random;
  estimates.random.resize(terms.size());
  for (std::size_t k = 0; k < terms.size(); ++k) {
    estimates.random[k].names = terms[k].coefficients;
    const bool is_finer = k + 1 == terms.size();
    estimates.random[k].labels = is_finer ? model.group_labels() : model.outer_labels();
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
