// SPDX-License-Identifier: MIT
// The content of a grammar's text, for derivation.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lsystem/lsystem_expression.hpp"
#include "silvafit/tree/lsystem.hpp"

namespace silvafit::tree {

/// A module of a successor, or of the axiom.
struct SuccessorModule {
  std::uint32_t symbol = 0;
  std::vector<LsystemExpression> parameters{};
};

struct Production {
  std::uint32_t symbol = 0;
  std::size_t parameter_count = 0;
  std::optional<LsystemExpression> condition{};
  std::optional<LsystemExpression> weight{};  ///< of randomly selected productions
  std::vector<SuccessorModule> successor{};
  std::size_t line = 0;
};

/// The productions of one symbol.
struct SymbolRules {
  std::vector<std::uint32_t> productions{};  ///< in the order of the text
  bool has_weights = false;
};

struct GrammarRules {
  std::string file{};
  std::shared_ptr<const std::vector<std::string>> alphabet{};
  std::map<std::string, double, std::less<>> constants{};
  TurtleSettings turtle{};
  int iterations = 0;
  std::vector<SuccessorModule> axiom{};
  std::size_t axiom_line = 0;
  std::vector<Production> productions{};
  std::vector<SymbolRules> of_symbol{};
  bool is_random = false;
  bool cuts = false;  ///< a successor or the axiom contains %
};

/// Of a grammar [bytes].
inline constexpr std::size_t kLongestText = 1 << 20;

/// \throws as Grammar::parse
GrammarRules parse_grammar(std::string_view text,
                           const std::string& file,
                           const std::map<std::string, double>& constants);

}  // namespace silvafit::tree
