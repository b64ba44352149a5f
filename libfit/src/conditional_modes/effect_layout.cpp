// SPDX-License-Identifier: MIT
#include "conditional_modes/effect_layout.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

EffectLayout::EffectLayout(const NonlinearModel& model)
    : cluster_begin_{0}, places_(model.term_count()) {
  for (const RandomEffects& term : model.specification().random) {
    shared_ += counts_.empty() ? 0 : counts_.back();
    counts_.push_back(static_cast<Index>(term.coefficients.size()));
  }
  Index place = 0;
  for (Index c = 0; c < model.cluster_count(); ++c) {
    for (std::size_t t = 0; t < terms(); ++t) {
      const bool is_last = t + 1 == terms();
      const Index groups = is_last ? model.cluster_begin(c + 1) - model.cluster_begin(c) : 1;
      for (Index k = 0; k < groups; ++k, place += counts_[t]) places_[t].push_back(place);
    }
    cluster_begin_.push_back(place);
  }
}

std::vector<MatrixXd> EffectLayout::by_term(const VectorXd& effects) const {
  std::vector<MatrixXd> result;
  for (std::size_t t = 0; t < terms(); ++t) {
    MatrixXd& of_term = result.emplace_back(count(t), std::ssize(places_[t]));
    for (Index k = 0; k < of_term.cols(); ++k) {
      of_term.col(k) = effects.segment(at(t, k), count(t));
    }
  }
  return result;
}

VectorXd EffectLayout::from_terms(const std::vector<MatrixXd>& terms) const {
  VectorXd result(size());
  for (std::size_t t = 0; t < terms.size(); ++t) {
    for (Index k = 0; k < terms[t].cols(); ++k) {
      result.segment(at(t, k), count(t)) = terms[t].col(k);
    }
  }
  return result;
}

}  // namespace silvafit::fit
