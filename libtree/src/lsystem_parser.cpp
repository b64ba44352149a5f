// SPDX-License-Identifier: MIT
// From a grammar's text to its rules.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "lsystem_rules.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kLongestText = 1 << 20;
constexpr std::size_t kMostProblems = 20;
constexpr std::size_t kMostParameters = 16;
constexpr std::size_t kMostDepth = 1000;
// More than anyone writes, and few enough to compare all with all.
constexpr std::size_t kMostProductions = 10000;
constexpr std::size_t kMostNames = 200;
// Symbols that are modules by themselves; letters are, too.
constexpr std::string_view kSymbols = "+-&^\\/|$!'%@[]{}";
constexpr std::string_view kArrow = "->";
constexpr std::string_view kLongArrow = "-->";

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_name(char c) { return is_letter(c) || is_digit(c) || c == '_'; }

/// How a character is spoken of in a message.
std::string shown(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte > ' ' && byte < 0x7f ? fmt::format("'{}'", c) : fmt::format("byte 0x{:02x}", byte);
}

/// A definition, setting or production with the lines that continue it.
struct Statement {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Comments become blanks, so that offsets stay those of the text.
std::string without_comments(std::string_view text) {
  std::string clean(text);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) clean.replace(0, 3, "   ");
  for (std::size_t i = 0; i < clean.size(); ++i) {
    if (clean[i] != '#') continue;
    const bool is_comment = i + 1 >= clean.size() || is_blank(clean[i + 1]) || clean[i + 1] == '#';
    if (!is_comment) continue;
    for (; i < clean.size() && clean[i] != '\n'; ++i) clean[i] = ' ';
  }
  return clean;
}

/// A line that begins with a blank continues the one before; empty lines count for nothing.
std::vector<Statement> statements_of(std::string_view text) {
  std::vector<Statement> statements;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    if (!std::all_of(line.begin(), line.end(), is_blank)) {
      if (is_blank(line.front()) && !statements.empty()) {
        statements.back().end = end;
      } else {
        statements.push_back({begin, end});
      }
    }
    begin = end + 1;
  }
  return statements;
}

class GrammarParser {
 public:
  GrammarParser(std::string_view text,
                const std::string& file,
                const std::map<std::string, double>& constants)
      : clean_(without_comments(text)), replaced_(constants) {
    rules_.file = file;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') line_begins_.push_back(i + 1);
    }
  }

  GrammarRules parse() {
    const std::vector<Statement> statements = statements_of(clean_);
    // Names of modules first: they say where one module ends and the next begins.
    std::vector<Statement> rest;
    for (const Statement& statement : statements) {
      guarded(statement, [&] {
        if (!read_module_names()) rest.push_back(statement);
      });
    }
    for (const Statement& statement : rest) guarded(statement, [&] { read(); });
    check_whole();
    if (!problems_.empty()) report();
    finish();
    return std::move(rules_);
  }

 private:
  [[noreturn]] static void fail(std::size_t offset, std::string message) {
    throw GrammarProblem{offset, std::move(message)};
  }

  /// One statement's mistake does not hide the next one's.
  template <typename Read>
  void guarded(const Statement& statement, Read read) {
    if (problems_.size() >= kMostProblems) return;
    text_ = std::string_view(clean_).substr(0, statement.end);
    position_ = statement.begin;
    statement_ = statement;
    try {
      read();
    } catch (GrammarProblem& problem) {
      problems_.push_back(std::move(problem));
    }
  }

  // ---- Characters -----------------------------------------------------------------------------

  void skip_blanks() {
    while (position_ < text_.size() && is_blank(text_[position_])) ++position_;
  }

  char peek() {
    skip_blanks();
    return position_ < text_.size() ? text_[position_] : '\0';
  }

  bool at_end() {
    skip_blanks();
    return position_ >= text_.size();
  }

  bool at(std::string_view token) {
    skip_blanks();
    return text_.substr(position_, token.size()) == token;
  }

  bool accept(std::string_view token) {
    if (!at(token)) return false;
    position_ += token.size();
    return true;
  }

  bool at_arrow() { return at(kArrow) || at(kLongArrow); }
  bool accept_arrow() { return accept(kLongArrow) || accept(kArrow); }

  std::string_view word() {
    skip_blanks();
    const std::size_t begin = position_;
    if (begin < text_.size() && is_digit(text_[begin])) return {};
    while (position_ < text_.size() && is_name(text_[position_])) ++position_;
    return text_.substr(begin, position_ - begin);
  }

  void expect_end(std::string_view after) {
    if (at_end()) return;
    fail(position_,
         fmt::format("unexpected {} after {}; a statement ends with its line, and a line that "
                     "begins with a blank continues the one before",
                     shown(text_[position_]),
                     after));
  }

  /// From 1.
  std::size_t line_of(std::size_t offset) const {
    return static_cast<std::size_t>(
        std::upper_bound(line_begins_.begin(), line_begins_.end(), offset) - line_begins_.begin());
  }

  /// From 1.
  std::size_t column_of(std::size_t offset) const {
    return offset - line_begins_[line_of(offset) - 1] + 1;
  }

  // ---- Statements -----------------------------------------------------------------------------

  /// modules: Apex, Whorl
  bool read_module_names() {
    if (word() != "modules" || !accept(":")) return false;
    do {
      skip_blanks();
      const std::size_t begin = position_;
      const std::string name(word());
      if (name.size() < 2 || !is_letter(name.front())) {
        fail(begin,
             "modules: lists names of two or more letters and digits, separated by commas; single "
             "letters are modules anyway");
      }
      if (long_names_.size() >= kMostNames) {
        fail(begin, fmt::format("{} long names at most", kMostNames));
      }
      if (!long_names_.insert(name).second) fail(begin, name + " is listed already");
    } while (accept(","));
    expect_end("a module's name");
    return true;
  }

  void read() {
    if (text_[position_] == '#') return read_directive();
    if (!read_setting()) read_production();
  }

  void read_directive() {
    const std::size_t begin = position_++;
    const bool is_define =
        word() == "define" && position_ < text_.size() && is_blank(text_[position_]);
    if (!is_define) {
      fail(begin,
           "only '#define NAME expression' begins with # and a letter; a comment begins with # and "
           "a blank");
    }
    skip_blanks();
    const std::size_t at_name = position_;
    const std::string name(word());
    if (name.empty()) fail(at_name, "#define needs a name and an expression: #define r1 0.8");
    if (rules_.constants.contains(name)) fail(at_name, name + " is defined already");
    const double value = constant_value("the value of " + name);
    expect_end("the value of " + name);
    const auto replaced = replaced_.find(name);
    rules_.constants[name] = replaced == replaced_.end() ? value : replaced->second;
  }

  ExpressionNames names_for(std::vector<std::string> parameters) const {
    return {.constants = &rules_.constants, .parameters = std::move(parameters)};
  }

  LsystemExpression expression(const ExpressionNames& names) {
    return LsystemExpression::parse(text_, position_, names);
  }

  /// What the same text always means.
  double constant_value(const std::string& what) {
    skip_blanks();
    const std::size_t begin = position_;
    const LsystemExpression value = expression(names_for({}));
    if (!value.is_constant()) {
      fail(begin, what + " must be one number; rnd and normal are for the axiom and productions");
    }
    Random unused(0);
    return value.value(nullptr, unused);
  }

  double setting_value(const std::string& name, double low, double high) {
    skip_blanks();
    const std::size_t begin = position_;
    const double value = constant_value(name);
    if (!(value >= low && value <= high)) {
      fail(begin, fmt::format("{} is {}, outside [{}, {}]", name, value, low, high));
    }
    return value;
  }

  /// \returns false if the statement is no setting
  bool read_setting() {
    const std::size_t begin = position_;
    const std::string name(word());
    if (name.size() < 2 || long_names_.contains(name) || !at(":")) {
      position_ = begin;
      return false;
    }
    accept(":");
    if (!set_.insert(name).second) fail(begin, name + " is set already");
    set(name, begin);
    expect_end(name);
    return true;
  }

  void set(const std::string& name, std::size_t begin) {
    constexpr double kLargest = 1e6;
    TurtleSettings& turtle = rules_.turtle;
    if (name == "axiom") {
      rules_.axiom_line = line_of(begin);
      rules_.axiom = modules(names_for({}), "the axiom");
    } else if (name == "iterations") {
      const double value = setting_value(name, 0, kMostIterations);
      if (value != std::floor(value)) fail(begin, "iterations must be a whole number");
      rules_.iterations = static_cast<int>(value);
    } else if (name == "angle") {
      turtle.angle_deg = setting_value(name, -360.0, 360.0);
    } else if (name == "length") {
      turtle.length = setting_value(name, 0.0, kLargest);
    } else if (name == "width") {
      turtle.width = setting_value(name, 0.0, kLargest);
    } else if (name == "width_ratio") {
      turtle.width_ratio = setting_value(name, 0.0, 1.0);
    } else if (name == "elasticity") {
      turtle.elasticity = setting_value(name, -kLargest, kLargest);
    } else if (name == "tropism") {
      turtle.tropism.x = setting_value(name, -kLargest, kLargest);
      expect_comma();
      turtle.tropism.y = setting_value(name, -kLargest, kLargest);
      expect_comma();
      turtle.tropism.z = setting_value(name, -kLargest, kLargest);
    } else {
      fail(begin,
           fmt::format(
               "there is no setting {}; there are modules, axiom, iterations, angle, length, "
               "width, width_ratio, tropism, elasticity; a module with a long name is listed "
               "in modules:",
               name.substr(0, 40)));
    }
  }

  void expect_comma() {
    if (!accept(",")) fail(position_, "tropism needs three numbers: east, north, up");
  }

  // ---- Modules --------------------------------------------------------------------------------

  std::uint32_t symbol_of(std::string_view name) {
    const auto found = symbols_.find(name);
    if (found != symbols_.end()) return found->second;
    const auto symbol = static_cast<std::uint32_t>(alphabet_.size());
    alphabet_.emplace_back(name);
    symbols_.emplace(name, symbol);
    return symbol;
  }

  /// The longest name in `modules:` that stands here, else one letter or symbol.
  std::string_view module_name() {
    const char c = peek();
    const std::size_t begin = position_;
    if (is_letter(c)) {
      std::size_t size = 1;
      for (const std::string& name : long_names_) {
        if (name.size() > size && at(name)) size = name.size();
      }
      position_ += size;
      return text_.substr(begin, size);
    }
    if (c == '~') {
      const char what = begin + 1 < text_.size() ? text_[begin + 1] : '\0';
      if (what != 'L' && what != 'B') {
        fail(begin, "'~' draws a leaf, ~L(length, grade), or a bud, ~B(length)");
      }
      position_ += 2;
      return text_.substr(begin, 2);
    }
    if (c != '\0' && kSymbols.find(c) != std::string_view::npos) {
      ++position_;
      return text_.substr(begin, 1);
    }
    if (c == '\0') fail(begin, "a module is missing here");
    if (c == '<' || c == '>') {
      fail(begin,
           "contexts ('<' and '>') are not part of this language; a production looks at one module "
           "only. Hand on what it must know as a parameter");
    }
    if (is_digit(c)) fail(begin, "a number stands in parentheses after its module: F(1)");
    if (c == '*') fail(begin, "'*' is no module; a successor that is empty is left empty");
    fail(begin, shown(c) + " is no module; see the list of symbols in docs/lsystem-trees.md");
  }

  std::vector<SuccessorModule> modules(const ExpressionNames& names, std::string_view where) {
    std::vector<SuccessorModule> list;
    std::vector<std::size_t> open;
    in_outline_ = false;
    while (!at_end()) {
      const std::size_t begin = position_;
      if (at_arrow() && !list.empty()) fail(begin, "a second '->'; each production begins a line");
      const std::string_view name = module_name();
      balance(name.front(), begin, open);
      SuccessorModule module{.symbol = symbol_of(name)};
      rules_.cuts = rules_.cuts || name == "%";
      if (peek() == '(') read_arguments(module, names, name);
      note_use(module.symbol, module.parameters.size());
      list.push_back(std::move(module));
    }
    if (!open.empty()) {
      fail(open.back(),
           fmt::format("this {} is not closed in {}", shown(clean_[open.back()]), where));
    }
    return list;
  }

  void balance(char c, std::size_t at_offset, std::vector<std::size_t>& open) {
    if (c == '[' || c == '{') {
      if (c == '{' && std::exchange(in_outline_, true)) {
        fail(at_offset, "an outline { } cannot stand in another");
      }
      if (open.size() >= kMostDepth) fail(at_offset, "brackets are nested too deeply");
      open.push_back(at_offset);
    } else if (c == ']' || c == '}') {
      const char wanted = c == ']' ? '[' : '{';
      if (open.empty()) fail(at_offset, fmt::format("'{}' without its '{}'", c, wanted));
      if (clean_[open.back()] != wanted) {
        fail(at_offset,
             fmt::format("'{}' closes the '{}' at column {}",
                         c,
                         clean_[open.back()],
                         column_of(open.back())));
      }
      open.pop_back();
      if (c == '}') in_outline_ = false;
    }
  }

  void read_arguments(SuccessorModule& module,
                      const ExpressionNames& names,
                      std::string_view name) {
    const std::size_t open = position_;
    if (name == "[" || name == "]" || name == "{" || name == "}" || name == "%") {
      fail(open, fmt::format("'{}' takes no parameters", name));
    }
    ++position_;
    if (accept(")")) return;
    do {
      if (module.parameters.size() >= kMostParameters) {
        fail(position_, fmt::format("a module has {} parameters at most", kMostParameters));
      }
      module.parameters.push_back(expression(names));
      if (module.parameters.back().draws_random_numbers()) rules_.is_random = true;
    } while (accept(","));
    if (!accept(")")) {
      if (at_end()) fail(open, "this '(' is not closed");
      fail(position_, fmt::format("',' or ')' is expected, not {}", shown(peek())));
    }
  }

  void note_use(std::uint32_t symbol, std::size_t parameters) {
    uses_.emplace(std::pair(symbol, parameters), statement_.begin);
  }

  // ---- Productions ----------------------------------------------------------------------------

  /// predecessor [: condition [: weight]] -> successor
  void read_production() {
    const std::size_t begin = position_;
    Production production{.line = line_of(begin)};
    const std::string_view name = module_name();
    if (std::string_view("[]{}%").find(name.front()) != std::string_view::npos) {
      fail(begin, fmt::format("'{}' cannot be rewritten", name));
    }
    production.symbol = symbol_of(name);
    std::vector<std::string> parameters = formal_parameters();
    production.parameter_count = parameters.size();
    const ExpressionNames names = names_for(std::move(parameters));
    const char next = peek();
    if (next == '<' || next == '>') module_name();
    if (!at_arrow() && next == ':') read_condition(production, names);
    if (!accept_arrow()) {
      if (at_end()) {
        fail(begin,
             "this is neither a #define, nor a setting (name: value), nor a production (A -> B)");
      }
      const bool is_word = std::isalpha(static_cast<unsigned char>(text_[position_])) != 0;
      fail(position_,
           fmt::format("':' or '->' is expected, not {}{}",
                       shown(text_[position_]),
                       is_word ? "; a name of several letters is declared by `modules:`" : ""));
    }
    production.successor = modules(names, "the successor");
    if (production.condition && production.condition->draws_random_numbers()) {
      rules_.is_random = true;
    }
    rules_.is_random = rules_.is_random || production.weight.has_value();
    if (rules_.productions.size() >= kMostProductions) {
      fail(begin, fmt::format("a grammar has {} productions at most", kMostProductions));
    }
    offsets_.push_back(begin);
    rules_.productions.push_back(std::move(production));
  }

  std::vector<std::string> formal_parameters() {
    std::vector<std::string> parameters;
    if (!at("(")) return parameters;
    const std::size_t open = position_++;
    if (accept(")")) return parameters;
    do {
      skip_blanks();
      const std::size_t begin = position_;
      const std::string name(word());
      if (name.empty()) {
        fail(begin,
             "a production's predecessor has names of parameters: A(l, w); a value that it "
             "must have goes to the condition: A(l) : l == 1 -> ...");
      }
      if (std::find(parameters.begin(), parameters.end(), name) != parameters.end()) {
        fail(begin, fmt::format("two parameters are named {}", name));
      }
      if (rules_.constants.contains(name)) {
        fail(begin, fmt::format("{} is #defined; give the parameter another name", name));
      }
      if (parameters.size() >= kMostParameters) {
        fail(begin, fmt::format("a module has {} parameters at most", kMostParameters));
      }
      parameters.push_back(name);
    } while (accept(","));
    if (!accept(")")) fail(open, "this '(' is not closed after names separated by commas");
    return parameters;
  }

  void read_condition(Production& production, const ExpressionNames& names) {
    accept(":");
    if (accept("*")) {
      // Always, as in cpfg.
    } else {
      LsystemExpression condition = expression(names);
      if (!condition.is_constant() || constant(condition) == 0.0) {
        production.condition = std::move(condition);
      }
    }
    if (!accept(":")) return;
    skip_blanks();
    const std::size_t begin = position_;
    production.weight = expression(names);
    if (production.weight->is_constant() && !(constant(*production.weight) > 0.0)) {
      fail(begin, "a weight must be above 0");
    }
  }

  static double constant(const LsystemExpression& expression) {
    Random unused(0);
    return expression.value(nullptr, unused);
  }

  // ---- The whole ------------------------------------------------------------------------------

  void check_whole() {
    for (const auto& [name, value] : replaced_) {
      if (!std::isfinite(value)) throw UsageError("the constant " + name + " must be finite");
      if (problems_.empty() && !rules_.constants.contains(name)) {
        throw UsageError(fmt::format("{} has no #define {}", rules_.file, name));
      }
    }
    if (!set_.contains("axiom")) {
      problems_.push_back(
          {clean_.size(), "there is no axiom; begin with a line such as axiom: A(1)"});
    } else if (rules_.axiom.empty() && problems_.empty()) {
      problems_.push_back({clean_.size(), "the axiom is empty"});
    }
    // What other mistakes left out would be missed here.
    if (problems_.empty()) {
      for (std::size_t i = 0; i < rules_.productions.size(); ++i) check_reached(i);
    }
  }

  /// A production that can never apply is a mistake that would otherwise show as a missing branch.
  void check_reached(std::size_t index) {
    const Production& production = rules_.productions[index];
    const std::string& name = alphabet_[production.symbol];
    const auto count = production.parameter_count;
    if (!uses_.contains({production.symbol, count})) {
      const auto other = uses_.lower_bound({production.symbol, 0});
      if (other != uses_.end() && other->first.first == production.symbol) {
        problems_.push_back(
            {offsets_[index],
             fmt::format("{} has {} parameter{} here, but {} in line {}; so this never applies",
                         name,
                         count,
                         count == 1 ? "" : "s",
                         other->first.second,
                         line_of(other->second))});
      }
      return;
    }
    for (std::size_t before = 0; before < index; ++before) {
      const Production& earlier = rules_.productions[before];
      const bool always = !earlier.condition && earlier.symbol == production.symbol &&
                          earlier.parameter_count == count;
      if (!always || (earlier.weight && production.weight)) continue;
      problems_.push_back(
          {offsets_[index],
           earlier.weight || production.weight
               ? fmt::format("{} is rewritten by weight in one and without weight in the other of "
                             "this and line {}; give both a weight, or conditions that exclude "
                             "each other",
                             name,
                             earlier.line)
               : fmt::format("this never applies: line {} comes first and has no condition",
                             earlier.line)});
      return;
    }
  }

  [[noreturn]] void report() {
    std::stable_sort(problems_.begin(), problems_.end(), [](const auto& a, const auto& b) {
      return a.offset < b.offset;
    });
    const auto place_of = [this](const GrammarProblem& problem) {
      return Place{.file = rules_.file,
                   .line = line_of(problem.offset),
                   .column = fmt::format("column {}", column_of(problem.offset))};
    };
    std::string message = problems_.front().message;
    for (std::size_t i = 1; i < problems_.size(); ++i) {
      message += '\n' + describe(place_of(problems_[i]), problems_[i].message);
    }
    if (problems_.size() >= kMostProblems) message += "\nand perhaps more";
    throw InputError(message, place_of(problems_.front()));
  }

  void finish() {
    rules_.of_symbol.resize(alphabet_.size());
    for (std::size_t i = 0; i < rules_.productions.size(); ++i) {
      SymbolRules& of_symbol = rules_.of_symbol[rules_.productions[i].symbol];
      of_symbol.productions.push_back(static_cast<std::uint32_t>(i));
      of_symbol.has_weights = of_symbol.has_weights || rules_.productions[i].weight.has_value();
    }
    rules_.alphabet = std::make_shared<const std::vector<std::string>>(std::move(alphabet_));
  }

  std::string clean_;  ///< the text with blanks for comments
  std::vector<std::size_t> line_begins_{0};
  const std::map<std::string, double>& replaced_;
  GrammarRules rules_{};
  std::vector<GrammarProblem> problems_{};
  std::vector<std::size_t> offsets_{};  ///< of productions
  std::set<std::string> long_names_{};
  std::set<std::string> set_{};
  std::vector<std::string> alphabet_{};
  std::map<std::string, std::uint32_t, std::less<>> symbols_{};
  /// Symbols and numbers of parameters in the axiom and successors, and where they first stand.
  std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> uses_{};
  std::string_view text_{};  ///< up to the end of the statement that is read
  std::size_t position_ = 0;
  Statement statement_{};
  bool in_outline_ = false;
};

}  // namespace

GrammarRules parse_grammar(std::string_view text,
                           const std::string& file,
                           const std::map<std::string, double>& constants) {
  if (text.size() > kLongestText) {
    throw InputError(fmt::format("has {} bytes; a grammar may have {}", text.size(), kLongestText),
                     {.file = file});
  }
  return GrammarParser(text, file, constants).parse();
}

}  // namespace silvafit::tree
