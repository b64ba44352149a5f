// SPDX-License-Identifier: MIT
// A fingerprint of the observations, to recognize fits to the same data.
#pragma once

#include <cstdint>
#include <string>

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// "sum64:" and sixteen hexadecimal digits: the sum of a hash of each value's bits, so that the
/// order of the rows does not matter. It detects accidental differences, not deliberate ones.
/// \param response  (N) the observations
/// The hash is the finalizer of MurmurHash3 (Appleby 2011, public domain).
std::string response_fingerprint(const Eigen::Ref<const VectorXd>& response);

/// The sum, which is additive over parts of the observations, and its text.
std::uint64_t response_sum(const Eigen::Ref<const VectorXd>& response);
std::string response_fingerprint(std::uint64_t sum);

}  // namespace silvafit::fit
