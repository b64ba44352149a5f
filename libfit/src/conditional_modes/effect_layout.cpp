// SPDX-License-Identifier: MIT
#include "conditional_modes/effect_layout.hpp"

#include "model/crossed_groups.hpp"

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
  model.crossed() != nullptr ? place_crossed(model) : place_nested(model);
}

void EffectLayout::place_nested(const NonlinearModel& model) {
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

void EffectLayout::place_crossed(const NonlinearModel& model) {
  const CrossedGroups& groups = *model.crossed();
  Index place = 0;
  for (Index c = 0; c < model.cluster_count(); ++c) {
    const auto number = static_cast<std::size_t>(c);
    for (std::size_t t = 0; t < terms(); ++t) {
      const Index count = groups.cluster_begin[t][number + 1] - groups.cluster_begin[t][number];
      for (Index k = 0; k < count; ++k, place += counts_[t]) places_[t].push_back(place);
    }
    const Index first = model.cluster_begin(c);
    const Index cells = model.cluster_begin(c + 1) - first;
    Eigen::MatrixXi of_cells(joint_count(), cells);
    for (Index k = 0; k < cells; ++k) {
      Index row = 0;
      for (std::size_t t = 0; t < terms(); ++t) {
        const Index begin = at(t, model.group_of(t, first + k)) - cluster_begin_.back();
        for (Index i = 0; i < counts_[t]; ++i) of_cells(row++, k) = static_cast<int>(begin + i);
      }
    }
    patterns_.push_back(
        std::make_shared<const SparsePattern>(place - cluster_begin_.back(), of_cells));
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
