// SPDX-License-Identifier: MIT
// Productions of a grammar that can never apply.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "lsystem/lsystem_rules.hpp"

namespace silvafit::tree {

struct UnreachedProduction {
  std::size_t index = 0;
  std::string why{};
};

/// Productions that no module matches, or that an earlier one always precedes: errors that
/// would otherwise show as a missing branch.
/// \param rules  complete, with their alphabet
std::vector<UnreachedProduction> unreached_productions(const GrammarRules& rules);

}  // namespace silvafit::tree
