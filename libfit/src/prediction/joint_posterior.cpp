// SPDX-License-Identifier: MIT
#include "prediction/joint_posterior.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "model/model_groups.hpp"
#include "model/symmetric_eigen.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

std::vector<Index> counts_of(const FittedModel& fit) {
  std::vector<Index> result;
  for (const EstimatedEffects& term : fit.random) result.push_back(std::ssize(term.names));
  return result;
}

}  // namespace

RandomPlaces places_of(const FittedModel& fit) {
  std::vector<std::vector<Index>> terms;
  for (const EstimatedEffects& term : fit.random) {
    std::vector<Index>& places = terms.emplace_back();
    for (const std::string& name : term.names) {
      places.push_back(std::ranges::find(fit.coefficient_names, name) -
                       fit.coefficient_names.begin());
    }
  }
  return RandomPlaces(std::move(terms));
}

JointPosterior::JointPosterior(const FittedModel& fit,
                               const EffectCells& cells,
                               std::vector<std::vector<std::string>> labels)
    : layout_(ModelGroups::one_cluster(std::move(labels), cells.groups), counts_of(fit)) {
  for (const EstimatedEffects& term : fit.random) {
    roots_.push_back(covariance_factor(term.covariance));
  }
  const RandomDesign design{.joint = places_of(fit).joint(roots_),
                            .shared = layout_.joint_count() - roots_.back().cols()};
  is_valid_ = factor_.compute(layout_.pattern(0), GroupPriors(design), cells.curvatures);
}

MatrixXd JointPosterior::solved(std::size_t term, Index group) const {
  const Index q = layout_.count(term);
  MatrixXd result = MatrixXd::Zero(layout_.size(), q);
  for (Index k = 0; k < q; ++k) {
    result(layout_.at(term, group) + k, k) = 1.0;
    factor_.solve(result.col(k));
  }
  return result;
}

std::vector<MatrixXd> JointPosterior::between_terms(
    const std::vector<std::vector<Index>>& combinations) const {
  const Index size = layout_.joint_count();
  std::vector<MatrixXd> result(combinations.size(), MatrixXd::Zero(size, size));
  const std::size_t terms = layout_.terms();
  std::vector<std::map<Index, std::vector<std::size_t>>> with(terms);  // combinations, by group
  for (std::size_t k = 0; k < combinations.size(); ++k) {
    if (!is_valid_) result[k].setConstant(kNaN);
    for (std::size_t t = 0; t < terms; ++t) {
      if (combinations[k][t] >= 0) with[t][combinations[k][t]].push_back(k);
    }
  }
  if (!is_valid_) return result;
  std::vector<Index> begin{0};
  for (std::size_t t = 0; t < terms; ++t) begin.push_back(begin.back() + layout_.count(t));
  // Of two terms one at least is not that with the most groups, whose equations are not solved.
  const auto most = static_cast<std::size_t>(
      std::ranges::max_element(with, {}, [](const auto& of) { return of.size(); }) - with.begin());
  for (std::size_t t = 0; t < terms; ++t) {
    if (t == most) continue;
    for (const auto& [group, members] : with[t]) {
      const MatrixXd right = solved(t, group) * roots_[t].transpose();
      for (const std::size_t k : members) {
        for (std::size_t s = 0; s < terms; ++s) {
          const Index other = combinations[k][s];
          if (other < 0 || s == t || (s != most && s < t)) continue;
          const Index q = layout_.count(s);
          const MatrixXd block = roots_[s] * right.middleRows(layout_.at(s, other), q);
          result[k].block(begin[s], begin[t], q, layout_.count(t)) = block;
          result[k].block(begin[t], begin[s], layout_.count(t), q) = block.transpose();
        }
      }
    }
  }
  return result;
}

}  // namespace silvafit::fit
