// SPDX-License-Identifier: MIT
// The terms of the series of the weights in the parameters of the variance function.
#include "likelihood/linearization.hpp"

namespace silvafit::fit {

const NonlinearModel::Strata* Linearizer::strata_of(std::size_t quantity) const {
  const int strata = variance_.quantities()[quantity].strata;
  return strata < 0 ? nullptr : &variance_.data().strata[static_cast<std::size_t>(strata)];
}

void Linearizer::make_terms() {
  const auto& quantities = variance_.quantities();
  const auto stratum_of = [&](std::size_t k, Index parameter) {
    return quantities[k].strata < 0 ? -1 : parameter + (quantities[k].has_reference ? 1 : 0);
  };
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    for (Index i = 0; i < quantities[k].count; ++i) {
      terms_.push_back({.quantity = k, .stratum = stratum_of(k, i)});
    }
  }
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    for (std::size_t l = k; l < quantities.size(); ++l) {
      const bool is_linear = variance_.log_scale()
                                 .derivative(quantities[k].name)
                                 .derivative(quantities[l].name)
                                 .is_zero();
      quantity_pairs_.push_back({.first = k, .second = l, .is_linear = is_linear});
      for (Index i = 0; i < quantities[k].count; ++i) {
        for (Index j = 0; j < quantities[l].count; ++j) {
          // No row belongs to two strata.
          const bool same_strata =
              quantities[k].strata >= 0 && quantities[k].strata == quantities[l].strata;
          if (same_strata && stratum_of(k, i) != stratum_of(l, j)) continue;
          pairs_.emplace_back(quantities[k].first + i, quantities[l].first + j);
          terms_.push_back({.pair = static_cast<int>(quantity_pairs_.size()) - 1,
                            .stratum = stratum_of(k, i),
                            .other_stratum = stratum_of(l, j)});
        }
      }
    }
  }
}

void Linearizer::add_terms(const Pass& pass,
                           const Segment& segment,
                           Index offset,
                           Scratch& scratch,
                           double* products,
                           ChunkSums& sums) const {
  const Index rows = segment.end - segment.begin;
  const auto first = static_cast<Index>(is_scalar_.size()) + 3;
  const auto quantity_count = static_cast<Index>(variance_.quantities().size());
  for (Index k = 0; k < quantity_count; ++k) {
    sums.log_squares[k] +=
        scratch.outputs.col(first + k).segment(offset, rows).array().square().sum();
  }
  Index second = first + quantity_count - 1;  // output of the current pair's second derivative
  int pair = -1;
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Term& term = terms_[t];
    if (term.pair != pair) {
      pair = term.pair;
      if (!is_linear(term)) ++second;
    }
    double sum = fill_term(term, segment, offset, second, scratch, pass.result);
    if (term.stratum >= 0 || term.other_stratum >= 0) {
      const std::optional<double> masked = mask_term(term, segment, offset, second, scratch);
      if (!masked) continue;
      sum = *masked;
    }
    sums.sum_log[static_cast<Index>(t) + 1] += sum;
    const auto width = static_cast<std::size_t>(pass.result.model.moments.width());
    add_products(scratch.term_weight.data(), rows, scratch, products + (t + 1) * width * width);
  }
}

bool Linearizer::is_linear(const Term& term) const {
  return term.pair < 0 || quantity_pairs_[static_cast<std::size_t>(term.pair)].is_linear;
}

std::pair<std::size_t, std::size_t> Linearizer::quantities_of(const Term& term) const {
  if (term.pair < 0) return {term.quantity, term.quantity};
  const QuantityPair& pair = quantity_pairs_[static_cast<std::size_t>(term.pair)];
  return {pair.first, pair.second};
}

Eigen::Map<const VectorXd> Linearizer::log_scale_slope(std::size_t quantity,
                                                       Index offset,
                                                       Index rows,
                                                       const Scratch& scratch) const {
  const auto first = static_cast<Index>(is_scalar_.size()) + 3;
  return {scratch.outputs.col(first + static_cast<Index>(quantity)).data() + offset, rows};
}

double Linearizer::fill_term(const Term& term,
                             const Segment& segment,
                             Index offset,
                             Index second,
                             Scratch& scratch,
                             const Linearization& result) const {
  const Index rows = segment.end - segment.begin;
  const auto [a, b] = quantities_of(term);
  const auto by_a = log_scale_slope(a, offset, rows, scratch).array();
  const auto by_b = log_scale_slope(b, offset, rows, scratch).array();
  const auto weight = result.weight.segment(segment.begin, rows);
  auto values = scratch.term_weight.head(rows).array();
  if (term.pair < 0) {
    values = -2.0 * weight * by_a;
    return by_a.sum();
  }
  if (is_linear(term)) {
    values = 4.0 * weight * by_a * by_b;
    return 0.0;
  }
  const auto curved = scratch.outputs.col(second).segment(offset, rows).array();
  values = weight * (4.0 * by_a * by_b - 2.0 * curved);
  return curved.sum();
}

std::optional<double> Linearizer::mask_term(
    const Term& term, const Segment& segment, Index offset, Index second, Scratch& scratch) const {
  const Index rows = segment.end - segment.begin;
  const auto [a, b] = quantities_of(term);
  const NonlinearModel::Strata* const strata = strata_of(a);
  const NonlinearModel::Strata* const others = strata_of(b);
  const auto by_a = log_scale_slope(a, offset, rows, scratch);
  double sum = 0.0;
  bool is_present = false;
  for (Index i = 0; i < rows; ++i) {
    const auto row = static_cast<std::size_t>(segment.begin + i);
    const bool inside = (term.stratum < 0 || strata->of_rows[row] == term.stratum) &&
                        (term.other_stratum < 0 || others->of_rows[row] == term.other_stratum);
    if (!inside) {
      scratch.term_weight[i] = 0.0;
      continue;
    }
    is_present = true;
    if (term.pair < 0) sum += by_a[i];
    if (!is_linear(term)) sum += scratch.outputs(offset + i, second);
  }
  return is_present ? std::optional(sum) : std::nullopt;
}

}  // namespace silvafit::fit
