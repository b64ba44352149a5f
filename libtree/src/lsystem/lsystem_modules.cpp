// SPDX-License-Identifier: MIT
#include "lsystem/lsystem_modules.hpp"

#include <fmt/format.h>

#include <utility>

namespace silvafit::tree {
namespace {

constexpr std::size_t kMostDepth = 1000;
// More than usual, and few enough to try all of them at each letter.
constexpr std::size_t kMostNames = 200;
// Symbols that are modules by themselves, like letters.
constexpr std::string_view kSymbols = "+-&^\\/|$!'%@[]{}";

[[noreturn]] void refuse_name(char c, std::size_t begin) {
  if (c == '\0') refuse_grammar(begin, "expected a module");
  if (c == '<' || c == '>') {
    refuse_grammar(begin,
                   "contexts ('<' and '>') are not supported: a production sees one module only. "
                   "Pass the information as a parameter");
  }
  if (is_digit(c)) refuse_grammar(begin, "put a number in parentheses after its module: F(1)");
  if (c == '*') {
    refuse_grammar(begin, "'*' is not a module; leave an empty successor blank");
  }
  refuse_grammar(begin,
                 shown(c) + " is not a module; see the list of symbols in docs/tree-builders.md");
}

/// The open branches [ ] and outlines { } at a position of a word.
class Brackets {
 public:
  explicit Brackets(const GrammarText& text) : text_(text) {}

  void pass(char c, std::size_t offset) {
    if (c == '[' || c == '{') open(c, offset);
    if (c == ']' || c == '}') close(c, offset);
  }

  void expect_closed(std::string_view where) const {
    if (open_.empty()) return;
    refuse_grammar(open_.back().offset,
                   fmt::format("this {} is not closed in {}", shown(open_.back().bracket), where));
  }

 private:
  struct Open {
    char bracket = '[';
    std::size_t offset = 0;
  };

  void open(char c, std::size_t offset) {
    if (c == '{' && std::exchange(in_outline_, true)) {
      refuse_grammar(offset, "outlines { } must not be nested");
    }
    if (open_.size() >= kMostDepth) refuse_grammar(offset, "brackets are nested too deeply");
    open_.push_back({c, offset});
  }

  void close(char c, std::size_t offset) {
    const char wanted = c == ']' ? '[' : '{';
    if (open_.empty())
      refuse_grammar(offset, fmt::format("'{}' without a matching '{}'", c, wanted));
    const Open& last = open_.back();
    if (last.bracket != wanted) {
      refuse_grammar(offset,
                     fmt::format("'{}' does not match the '{}' at column {}",
                                 c,
                                 last.bracket,
                                 text_.column_of(last.offset)));
    }
    open_.pop_back();
    if (c == '}') in_outline_ = false;
  }

  const GrammarText& text_;
  std::vector<Open> open_{};
  bool in_outline_ = false;
};

/// The parameters in the parentheses that begin here.
std::vector<LsystemExpression> arguments(GrammarCursor& cursor,
                                         const ExpressionNames& names,
                                         std::string_view name) {
  std::vector<LsystemExpression> parameters;
  const std::size_t open = cursor.position();
  if (name == "[" || name == "]" || name == "{" || name == "}" || name == "%") {
    refuse_grammar(open, fmt::format("'{}' takes no parameters", name));
  }
  cursor.accept("(");
  if (cursor.accept(")")) return parameters;
  do {
    if (parameters.size() >= kMostParameters) {
      refuse_grammar(cursor.position(),
                     fmt::format("a module may have at most {} parameters", kMostParameters));
    }
    parameters.push_back(LsystemExpression::parse(cursor, names));
  } while (cursor.accept(","));
  if (!cursor.accept(")")) {
    if (cursor.at_end()) refuse_grammar(open, "this '(' is not closed");
    refuse_grammar(cursor.position(),
                   fmt::format("expected ',' or ')', not {}", shown(cursor.peek())));
  }
  return parameters;
}

}  // namespace

void ModuleReader::declare(GrammarCursor& cursor) {
  do {
    cursor.skip_blanks();
    const std::size_t begin = cursor.position();
    const std::string name(cursor.word());
    if (name.size() < 2 || !is_letter(name.front())) {
      refuse_grammar(
          begin,
          "modules: lists names of two or more letters and digits, separated by commas; single "
          "letters are modules anyway");
    }
    if (long_names_.size() >= kMostNames) {
      refuse_grammar(begin, fmt::format("at most {} long names are allowed", kMostNames));
    }
    if (!long_names_.insert(name).second) refuse_grammar(begin, name + " is listed twice");
  } while (cursor.accept(","));
}

std::string_view ModuleReader::name(GrammarCursor& cursor) const {
  const char c = cursor.peek();
  const std::size_t begin = cursor.position();
  if (is_letter(c)) {
    std::size_t size = 1;
    for (const std::string& name : long_names_) {
      if (name.size() > size && cursor.at(name)) size = name.size();
    }
    return cursor.take(size);
  }
  if (c == '~') {
    if (!cursor.at("~L") && !cursor.at("~B")) {
      refuse_grammar(begin,
                     "'~' must be followed by a leaf, ~L(length, grade), or a bud, ~B(length)");
    }
    return cursor.take(2);
  }
  if (c != '\0' && kSymbols.find(c) != std::string_view::npos) return cursor.take(1);
  refuse_name(c, begin);
}

std::uint32_t ModuleReader::symbol_of(std::string_view name) {
  const auto found = symbols_.find(name);
  if (found != symbols_.end()) return found->second;
  const auto symbol = static_cast<std::uint32_t>(alphabet_.size());
  alphabet_.emplace_back(name);
  symbols_.emplace(name, symbol);
  return symbol;
}

std::vector<SuccessorModule> ModuleReader::word(GrammarCursor& cursor,
                                                const ExpressionNames& names,
                                                std::string_view where) {
  std::vector<SuccessorModule> modules;
  Brackets brackets(text_);
  while (!cursor.at_end()) {
    const std::size_t begin = cursor.position();
    if (cursor.at_arrow() && !modules.empty()) {
      refuse_grammar(begin, "a second '->' in a line; each production needs its own line");
    }
    const std::string_view symbol = name(cursor);
    brackets.pass(symbol.front(), begin);
    SuccessorModule module{.symbol = symbol_of(symbol)};
    if (cursor.peek() == '(') module.parameters = arguments(cursor, names, symbol);
    modules.push_back(std::move(module));
  }
  brackets.expect_closed(where);
  return modules;
}

}  // namespace silvafit::tree
