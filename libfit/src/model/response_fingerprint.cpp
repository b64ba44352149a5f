// SPDX-License-Identifier: MIT
#include "model/response_fingerprint.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>

namespace silvafit::fit {
namespace {

std::uint64_t mixed(std::uint64_t bits) {
  bits ^= bits >> 33U;
  bits *= 0xff51afd7ed558ccdU;
  bits ^= bits >> 33U;
  bits *= 0xc4ceb9fe1a85ec53U;
  bits ^= bits >> 33U;
  return bits;
}

}  // namespace

std::uint64_t response_sum(const Eigen::Ref<const VectorXd>& response) {
  std::uint64_t sum = 0;
  // Adding zero makes -0 and 0 equal; adding one prevents that zeros have the hash 0.
  for (const double value : response) sum += mixed(std::bit_cast<std::uint64_t>(value + 0.0) + 1);
  return sum;
}

std::string response_fingerprint(std::uint64_t sum) { return fmt::format("sum64:{:016x}", sum); }

std::string response_fingerprint(const Eigen::Ref<const VectorXd>& response) {
  return response_fingerprint(response_sum(response));
}

}  // namespace silvafit::fit
