// SPDX-License-Identifier: MIT
// Nested random-effects structures of a model, and conversion of fits between them.
#pragma once

#include <string>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// A model with one random effect fewer, or with independent random effects instead of correlated
/// ones.
struct SmallerStructure {
  NonlinearModel model;
  std::string text{};    ///< "without the random effect of a"
  std::size_t term = 0;  ///< that has changed
  Index left_out = -1;   ///< the omitted effect; -1 for independent effects
};

/// The structures one step smaller: without each effect of a term that has several, and with a
/// diagonal covariance.
std::vector<SmallerStructure> smaller_structures(const NonlinearModel& model);

/// A fit of the whole model as a start of the smaller one.
MixedEffectsFit reduced(const MixedEffectsFit& fit, const SmallerStructure& smaller);

/// A standard deviation for the omitted effect: a tenth of the one that changes the mean by a
/// residual standard deviation at a fit.
double small_deviation(const NonlinearModel& model,
                       const SmallerStructure& smaller,
                       const MixedEffectsFit& fit);

/// A fit of the smaller model as a start of the whole one. The omitted effect gets a small
/// variance, because a variance of zero would be a stationary point.
/// \param deviation  its standard deviation
MixedEffectsFit enlarged(const MixedEffectsFit& fit,
                         const SmallerStructure& smaller,
                         double deviation);

}  // namespace silvafit::fit
