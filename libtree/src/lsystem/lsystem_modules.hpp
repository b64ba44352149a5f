// SPDX-License-Identifier: MIT
// The modules of a grammar's text: their names, and the words made of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "lsystem/lsystem_rules.hpp"
#include "lsystem/lsystem_text.hpp"

namespace silvafit::tree {

/// Maximum number of parameters of a module.
constexpr std::size_t kMostParameters = 16;

/// Reads modules, and numbers their symbols in the order of first occurrence.
class ModuleReader {
 public:
  /// \param text  for the columns in messages; it must outlive the reader
  explicit ModuleReader(const GrammarText& text) : text_(text) {}

  /// Reads the names after `modules:`, such as Apex, Whorl. All must be known before the first
  /// word is read, because they separate the modules of a word.
  /// \throws GrammarProblem
  void declare(GrammarCursor& cursor);
  bool is_declared(const std::string& name) const { return long_names_.contains(name); }

  /// The longest declared name at the cursor, else one letter or symbol.
  /// \throws GrammarProblem if no module begins here
  std::string_view name(GrammarCursor& cursor) const;

  /// The index of a symbol; a new one if it has none.
  std::uint32_t symbol_of(std::string_view name);
  bool has_symbol(std::string_view name) const { return symbols_.contains(name); }
  /// All symbols, by their number.
  const std::vector<std::string>& alphabet() const { return alphabet_; }

  /// The modules from here to the end of the statement, with balanced brackets.
  /// \param where  name of this part for messages: "the axiom"
  /// \throws GrammarProblem
  std::vector<SuccessorModule> word(GrammarCursor& cursor,
                                    const ExpressionNames& names,
                                    std::string_view where);

 private:
  const GrammarText& text_;
  std::set<std::string> long_names_{};
  std::vector<std::string> alphabet_{};
  std::map<std::string, std::uint32_t, std::less<>> symbols_{};
};

}  // namespace silvafit::tree
