// SPDX-License-Identifier: MIT
#include "conditional_modes/random_places.hpp"

#include <algorithm>
#include <utility>

namespace silvafit::fit {
namespace {

std::vector<Index> united(const std::vector<std::vector<Index>>& lists) {
  std::vector<Index> all;
  for (const std::vector<Index>& list : lists) all.insert(all.end(), list.begin(), list.end());
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

RandomPlaces::RandomPlaces(std::vector<std::vector<Index>> of_terms)
    : terms(std::move(of_terms)), all(united(terms)) {
  for (const std::vector<Index>& term : terms) {
    std::vector<Index>& places = rows.emplace_back();
    for (const Index value : term) places.push_back(std::ranges::find(all, value) - all.begin());
  }
}

std::vector<MatrixXd> RandomPlaces::no_effects(const NonlinearModel& model) const {
  std::vector<MatrixXd> result;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    result.emplace_back(MatrixXd::Zero(q(t), model.group_count(t)));
  }
  return result;
}

SmallMatrix RandomPlaces::joint(const std::vector<MatrixXd>& factors) const {
  Index effects = 0;
  for (const MatrixXd& factor : factors) effects += factor.cols();
  SmallMatrix result = SmallMatrix::Zero(r(), effects);
  Index column = 0;
  for (std::size_t t = 0; t < factors.size(); ++t) {
    add_placed(factors[t], rows[t], column, result);
    column += factors[t].cols();
  }
  return result;
}

void add_placed(const MatrixXd& factor,
                const std::vector<Index>& rows,
                Index column,
                SmallMatrix& sum) {
  if (factor.cols() == 0) return;  // an empty factor has no data pointer
  for (std::size_t k = 0; k < rows.size(); ++k) {
    sum.row(rows[k]).segment(column, factor.cols()) += factor.row(static_cast<Index>(k));
  }
}

}  // namespace silvafit::fit
