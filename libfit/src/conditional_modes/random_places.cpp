// SPDX-License-Identifier: MIT
#include "conditional_modes/random_places.hpp"

#include <algorithm>

#include "model/nested_terms.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;

std::vector<Index> united(std::vector<Index> a, const std::vector<Index>& b) {
  a.insert(a.end(), b.begin(), b.end());
  std::ranges::sort(a);
  a.erase(std::unique(a.begin(), a.end()), a.end());
  return a;
}

std::vector<Index> positions(const std::vector<Index>& of, const std::vector<Index>& in) {
  std::vector<Index> result;
  result.reserve(of.size());
  for (const Index value : of) result.push_back(std::ranges::find(in, value) - in.begin());
  return result;
}

}  // namespace

RandomPlaces::RandomPlaces(const NonlinearModel& model)
    : outer(model.coefficients_of(coarser_term(model.specification()))),
      inner(model.coefficients_of(finer_term(model.specification()))),
      all(united(outer, inner)),
      outer_rows(positions(outer, all)),
      inner_rows(positions(inner, all)) {}

void add_placed(const Eigen::MatrixXd& factor, const std::vector<Index>& rows, SmallMatrix& sum) {
  if (factor.cols() == 0) return;  // an empty factor has no data pointer
  for (std::size_t k = 0; k < rows.size(); ++k) {
    sum.row(rows[k]) += factor.row(static_cast<Index>(k));
  }
}

}  // namespace silvafit::fit
