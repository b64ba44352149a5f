// SPDX-License-Identifier: MIT
// The modules of a grammar's text: their names, and the words that are made of them.
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

/// How many parameters a module may have.
constexpr std::size_t kMostParameters = 16;

/// Reads modules, and numbers their symbols as it meets them.
class ModuleReader {
 public:
  /// \param text  for the columns in messages; it must outlive the reader
  explicit ModuleReader(const GrammarText& text) : text_(text) {}

  /// Reads the names after `modules:`, such as Apex, Whorl. They must all be known before the first
  /// word is read: they say where one module ends and the next begins.
  /// \throws GrammarProblem
  void declare(GrammarCursor& cursor);
  bool is_declared(const std::string& name) const { return long_names_.contains(name); }

  /// The longest declared name that stands here, else one letter or symbol.
  /// \throws GrammarProblem if no module begins here
  std::string_view name(GrammarCursor& cursor) const;

  /// The number of a symbol; a new one where it has none yet.
  std::uint32_t symbol_of(std::string_view name);
  bool has_symbol(std::string_view name) const { return symbols_.contains(name); }
  /// All symbols, by their number.
  const std::vector<std::string>& alphabet() const { return alphabet_; }

  /// The modules from here to the end of the statement, with balanced brackets.
  /// \param where  what they are, for messages: "the axiom"
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
