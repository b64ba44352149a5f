// SPDX-License-Identifier: MIT
#include "model/simpler_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

namespace silvafit::fit {

std::string simpler_model(const ModelSpecification& specification) {
  std::size_t effects = 0;
  bool has_covariances = false;
  for (const RandomEffects& term : specification.random) {
    effects += term.coefficients.size();
    has_covariances |= std::ranges::any_of(term.block_sizes(), [](int size) { return size > 1; });
  }
  std::vector<std::string> ways;
  if (effects > 1) ways.emplace_back("fewer random effects");
  if (has_covariances) ways.emplace_back("a diagonal covariance matrix");
  if (!specification.variance.factors.empty()) ways.emplace_back("a simpler variance function");
  if (specification.correlation) ways.emplace_back("a simpler correlation of the residuals");
  if (ways.empty()) return "a curve with fewer coefficients";
  if (ways.size() == 1) return ways.front();
  return fmt::format("{} or {}", fmt::join(ways.begin(), ways.end() - 1, ", "), ways.back());
}

}  // namespace silvafit::fit
