// SPDX-License-Identifier: MIT
// What can be taken away from a model.
#pragma once

#include <algorithm>
#include <cstddef>

#include "silvafit/fit/finding.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

inline Reducible reducible(const ModelSpecification& specification) {
  std::size_t effects = 0;
  Reducible result{.variance = !specification.variance.factors.empty(),
                   .correlation = specification.correlation.has_value()};
  for (const RandomEffects& term : specification.random) {
    effects += term.coefficients.size();
    result.covariances |=
        std::ranges::any_of(term.block_sizes(), [](int size) { return size > 1; });
  }
  result.effects = effects > 1;
  return result;
}

}  // namespace silvafit::fit
