// SPDX-License-Identifier: MIT
#include "conditional_modes/effect_layout.hpp"

#include <numeric>
#include <utility>

#include "model/model_groups.hpp"

namespace silvafit::fit {

namespace {

std::vector<Index> effect_counts(const std::vector<RandomEffects>& terms) {
  std::vector<Index> result;
  for (const RandomEffects& term : terms) result.push_back(std::ssize(term.coefficients));
  return result;
}

}  // namespace

EffectLayout::EffectLayout(const NonlinearModel& model)
    : EffectLayout(model.groups(), effect_counts(model.specification().random)) {}

EffectLayout::EffectLayout(const ModelGroups& groups, std::vector<Index> counts)
    : counts_(std::move(counts)),
      shared_(std::accumulate(counts_.begin(), counts_.end(), Index{0}) -
              (counts_.empty() ? 0 : counts_.back())),
      first_cell_(groups.first_cell),
      cluster_begin_{0},
      places_(counts_.size()) {
  Index place = 0;
  for (Index c = 0; c + 1 < std::ssize(first_cell_); ++c) {
    const auto number = static_cast<std::size_t>(c);
    for (std::size_t t = 0; t < terms(); ++t) {
      const Index count = groups.cluster_begin[t][number + 1] - groups.cluster_begin[t][number];
      for (Index k = 0; k < count; ++k, place += counts_[t]) places_[t].push_back(place);
    }
    if (groups.is_crossed) add_pattern(groups, c, place - cluster_begin_.back());
    cluster_begin_.push_back(place);
  }
}

void EffectLayout::add_pattern(const ModelGroups& groups, Index cluster, Index size) {
  const Index first = first_cell(cluster);
  Eigen::MatrixXi of_cells(joint_count(), first_cell(cluster + 1) - first);
  for (Index k = 0; k < of_cells.cols(); ++k) {
    Index row = 0;
    for (std::size_t t = 0; t < terms(); ++t) {
      const Index begin = at(t, groups.group_of(t, first + k)) - cluster_begin_.back();
      for (Index i = 0; i < counts_[t]; ++i) of_cells(row++, k) = static_cast<int>(begin + i);
    }
  }
  patterns_.push_back(std::make_shared<const SparsePattern>(size, of_cells));
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
