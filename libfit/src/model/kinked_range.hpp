// SPDX-License-Identifier: MIT
// Correlations with kinks of the likelihood.
#pragma once

#include "correlation/correlation_structure.hpp"
#include "model/correlated_rows.hpp"

namespace silvafit::fit {

/// Whether the likelihood has a kink at each range that is a distance of two rows: a linear
/// correlation reaches 0 with a slope there.
inline bool has_kinked_range(const CorrelatedRows* rows) {
  return rows != nullptr && rows->structure().correlation().kind == Correlation::Kind::kLinear;
}

}  // namespace silvafit::fit
