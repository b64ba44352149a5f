// SPDX-License-Identifier: MIT
// The random-effects terms of a model: one grouping, or two nested ones.
#pragma once

#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// The term of the only or the finer grouping; null without random effects.
inline const RandomEffects* finer_term(const ModelSpecification& specification) {
  return specification.random.empty() ? nullptr : &specification.random.back();
}

/// The term of the coarser of two nested groupings; null without one.
inline const RandomEffects* coarser_term(const ModelSpecification& specification) {
  return specification.random.size() < 2 ? nullptr : &specification.random.front();
}

/// A term, without coefficients if there is none.
inline RandomEffects or_none(const RandomEffects* term) {
  return term == nullptr ? RandomEffects{} : *term;
}

}  // namespace silvafit::fit
