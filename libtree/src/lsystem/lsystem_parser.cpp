// SPDX-License-Identifier: MIT
// Parser of a grammar's text.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "lsystem/lsystem_modules.hpp"
#include "lsystem/lsystem_rules.hpp"
#include "lsystem/lsystem_text.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kMostProblems = 20;
// More than usual, and few enough to compare all with all.
constexpr std::size_t kMostProductions = 10000;

/// The value of an expression that is_constant().
double constant(const LsystemExpression& expression) {
  Random unused(0);
  return expression.value(nullptr, unused);
}

bool draws_random_numbers(const std::vector<SuccessorModule>& word) {
  return std::any_of(word.begin(), word.end(), [](const SuccessorModule& module) {
    return std::any_of(module.parameters.begin(),
                       module.parameters.end(),
                       [](const auto& parameter) { return parameter.draws_random_numbers(); });
  });
}

bool is_random(const Production& production) {
  return production.weight.has_value() ||
         (production.condition && production.condition->draws_random_numbers()) ||
         draws_random_numbers(production.successor);
}

/// Symbols and numbers of parameters in the axiom and successors, and the first line with them.
using Uses = std::map<std::pair<std::uint32_t, std::size_t>, std::size_t>;

void note(const std::vector<SuccessorModule>& word, std::size_t line, Uses& uses) {
  for (const SuccessorModule& module : word) {
    const auto [use, is_new] = uses.try_emplace({module.symbol, module.parameters.size()}, line);
    if (!is_new) use->second = std::min(use->second, line);
  }
}

Uses uses_of(const GrammarRules& rules) {
  Uses uses;
  note(rules.axiom, rules.axiom_line, uses);
  for (const Production& production : rules.productions) {
    note(production.successor, production.line, uses);
  }
  return uses;
}

/// The reason why no module has the production's symbol and number of parameters. Empty if none has
/// the symbol at all: grammars may contain unused productions.
std::string why_unmet(const GrammarRules& rules, const Uses& uses, const Production& production) {
  const auto count = production.parameter_count;
  const auto other = uses.lower_bound({production.symbol, 0});
  if (other == uses.end() || other->first.first != production.symbol) return {};
  return fmt::format("{} has {} parameter{} here, but {} in line {}; this production never applies",
                     (*rules.alphabet)[production.symbol],
                     count,
                     count == 1 ? "" : "s",
                     other->first.second,
                     other->second);
}

/// Empty if no earlier production matches all of this one's modules.
std::string why_preceded(const GrammarRules& rules, std::size_t index) {
  const Production& production = rules.productions[index];
  for (std::size_t before = 0; before < index; ++before) {
    const Production& earlier = rules.productions[before];
    const bool always = !earlier.condition && earlier.symbol == production.symbol &&
                        earlier.parameter_count == production.parameter_count;
    if (!always || (earlier.weight && production.weight)) continue;
    if (!earlier.weight && !production.weight) {
      return fmt::format("this production never applies: line {} comes first and has no condition",
                         earlier.line);
    }
    return fmt::format(
        "of this production and that of line {1}, which rewrite {0}, only one has a weight; give "
        "both a weight, or conditions that exclude each other",
        (*rules.alphabet)[production.symbol],
        earlier.line);
  }
  return {};
}

struct UnreachedProduction {
  std::size_t index = 0;
  std::string why{};
};

/// Productions that no module matches, or that an earlier one always precedes: errors that
/// would otherwise show as a missing branch.
/// \param rules  complete, with their alphabet
std::vector<UnreachedProduction> unreached_productions(const GrammarRules& rules) {
  const Uses uses = uses_of(rules);
  std::vector<UnreachedProduction> unreached;
  for (std::size_t i = 0; i < rules.productions.size(); ++i) {
    const Production& production = rules.productions[i];
    const bool is_met = uses.contains({production.symbol, production.parameter_count});
    std::string why = is_met ? why_preceded(rules, i) : why_unmet(rules, uses, production);
    if (!why.empty()) unreached.push_back({i, std::move(why)});
  }
  return unreached;
}

class GrammarParser {
 public:
  GrammarParser(std::string_view text,
                const std::string& file,
                const std::map<std::string, double>& constants)
      : text_(text), modules_(text_), replaced_(constants) {
    rules_.file = file;
  }

  GrammarRules parse() {
    std::vector<Statement> rest;
    for (const Statement& statement : text_.statements()) {
      guarded(statement, [&] {
        if (!read_module_names()) rest.push_back(statement);
      });
    }
    for (const Statement& statement : rest) guarded(statement, [&] { read(); });
    finish();
    check_whole();
    if (!problems_.empty()) report();
    return std::move(rules_);
  }

 private:
  using Statement = GrammarText::Statement;

  /// An error in one statement does not hide errors in the next one.
  template <typename Read>
  void guarded(const Statement& statement, Read read) {
    if (problems_.size() >= kMostProblems) return;
    cursor_ = text_.at(statement);
    try {
      read();
    } catch (GrammarProblem& problem) {
      problems_.push_back(std::move(problem));
    }
  }

  void expect_end(std::string_view after) {
    if (cursor_.at_end()) return;
    refuse_grammar(cursor_.position(),
                   fmt::format("unexpected {} after {}; start a new statement on a new line (a "
                               "line that begins with a space continues the previous one)",
                               shown(cursor_.peek()),
                               after));
  }

  // ---- Statements -----------------------------------------------------------------------------

  /// modules: Apex, Whorl
  bool read_module_names() {
    if (cursor_.word() != "modules" || !cursor_.accept(":")) return false;
    modules_.declare(cursor_);
    expect_end("the name of a module");
    return true;
  }

  void read() {
    if (cursor_.next() == '#') return read_directive();
    if (!read_setting()) read_production();
  }

  void read_directive() {
    const std::size_t begin = cursor_.position();
    cursor_.accept("#");
    const bool is_define = cursor_.word() == "define" && is_blank(cursor_.next());
    if (!is_define) {
      refuse_grammar(begin,
                     "unknown directive; use '#define NAME expression', or '# ' for a comment");
    }
    cursor_.skip_blanks();
    const std::size_t at_name = cursor_.position();
    const std::string name(cursor_.word());
    if (name.empty()) {
      refuse_grammar(at_name, "#define needs a name and an expression: #define r1 0.8");
    }
    if (rules_.constants.contains(name)) refuse_grammar(at_name, name + " is defined twice");
    const double value = constant_value("the value of " + name);
    expect_end("the value of " + name);
    const auto replaced = replaced_.find(name);
    rules_.constants[name] = replaced == replaced_.end() ? value : replaced->second;
  }

  ExpressionNames names_for(std::vector<std::string> parameters) const {
    return {.constants = &rules_.constants, .parameters = std::move(parameters)};
  }

  /// Settings that do not depend on the other statements.
  double constant_value(const std::string& what) {
    cursor_.skip_blanks();
    const std::size_t begin = cursor_.position();
    const LsystemExpression value = LsystemExpression::parse(cursor_, names_for({}));
    if (!value.is_constant()) {
      refuse_grammar(begin,
                     what +
                         " must be one number; rnd and normal are allowed only in the axiom and in "
                         "productions");
    }
    return constant(value);
  }

  double setting_value(const std::string& name, double low, double high) {
    cursor_.skip_blanks();
    const std::size_t begin = cursor_.position();
    const double value = constant_value(name);
    if (!(value >= low && value <= high)) {
      refuse_grammar(begin, fmt::format("{} is {}, outside [{}, {}]", name, value, low, high));
    }
    return value;
  }

  /// \returns false if the statement is not a setting
  bool read_setting() {
    const std::size_t begin = cursor_.position();
    const std::string name(cursor_.word());
    if (name.size() < 2 || modules_.is_declared(name) || !cursor_.at(":")) {
      cursor_.move_to(begin);
      return false;
    }
    cursor_.accept(":");
    if (!set_.insert(name).second) refuse_grammar(begin, name + " is set twice");
    set(name, begin);
    expect_end(name);
    return true;
  }

  void set(const std::string& name, std::size_t begin) {
    constexpr double kLargest = 1e6;
    TurtleSettings& turtle = rules_.turtle;
    if (name == "axiom") {
      rules_.axiom_line = text_.line_of(begin);
      rules_.axiom = modules_.word(cursor_, names_for({}), "the axiom");
    } else if (name == "iterations") {
      const double value = setting_value(name, 0, kMostIterations);
      if (value != std::floor(value)) refuse_grammar(begin, "iterations must be an integer");
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
      refuse_grammar(
          begin,
          fmt::format(
              "unknown setting '{}'; available: modules, axiom, iterations, angle, length, width, "
              "width_ratio, tropism, elasticity. Declare a module with a long name in modules:",
              name.substr(0, 40)));
    }
  }

  void expect_comma() {
    if (!cursor_.accept(",")) {
      refuse_grammar(cursor_.position(), "tropism needs three numbers: east, north, up");
    }
  }

  // ---- Productions ----------------------------------------------------------------------------

  /// predecessor [: condition [: weight]] -> successor
  void read_production() {
    const std::size_t begin = cursor_.position();
    Production production{.line = text_.line_of(begin)};
    const std::string_view name = modules_.name(cursor_);
    if (std::string_view("[]{}%").find(name.front()) != std::string_view::npos) {
      refuse_grammar(begin, fmt::format("'{}' cannot be rewritten", name));
    }
    production.symbol = modules_.symbol_of(name);
    std::vector<std::string> parameters = formal_parameters();
    production.parameter_count = parameters.size();
    const ExpressionNames names = names_for(std::move(parameters));
    const char next = cursor_.peek();
    if (next == '<' || next == '>') modules_.name(cursor_);  // which says why not
    if (!cursor_.at_arrow() && next == ':') read_condition(production, names);
    expect_arrow(begin);
    production.successor = modules_.word(cursor_, names, "the successor");
    if (rules_.productions.size() >= kMostProductions) {
      refuse_grammar(begin,
                     fmt::format("a grammar may have at most {} productions", kMostProductions));
    }
    offsets_.push_back(begin);
    rules_.productions.push_back(std::move(production));
  }

  void expect_arrow(std::size_t begin) {
    if (cursor_.accept_arrow()) return;
    if (cursor_.at_end()) {
      refuse_grammar(begin, "not a #define, a setting (name: value) or a production (A -> B)");
    }
    const char c = cursor_.peek();
    refuse_grammar(
        cursor_.position(),
        fmt::format("expected ':' or '->', not {}{}",
                    shown(c),
                    is_letter(c) ? "; declare a name of several letters with 'modules:'" : ""));
  }

  std::vector<std::string> formal_parameters() {
    std::vector<std::string> parameters;
    if (!cursor_.at("(")) return parameters;
    const std::size_t open = cursor_.position();
    cursor_.accept("(");
    if (cursor_.accept(")")) return parameters;
    do {
      cursor_.skip_blanks();
      const std::size_t begin = cursor_.position();
      const std::string name(cursor_.word());
      if (name.empty()) {
        refuse_grammar(begin,
                       "the predecessor of a production needs parameter names: A(l, w); use a "
                       "condition for a required value: A(l) : l == 1 -> ...");
      }
      if (std::find(parameters.begin(), parameters.end(), name) != parameters.end()) {
        refuse_grammar(begin, fmt::format("two parameters have the name {}", name));
      }
      if (rules_.constants.contains(name)) {
        refuse_grammar(begin, fmt::format("{} is #defined; use another parameter name", name));
      }
      if (parameters.size() >= kMostParameters) {
        refuse_grammar(begin,
                       fmt::format("a module may have at most {} parameters", kMostParameters));
      }
      parameters.push_back(name);
    } while (cursor_.accept(","));
    if (!cursor_.accept(")")) {
      refuse_grammar(open, "this '(' is not closed; expected names separated by commas");
    }
    return parameters;
  }

  void read_condition(Production& production, const ExpressionNames& names) {
    cursor_.accept(":");
    if (cursor_.accept("*")) {
      // As in cpfg, the condition * always holds.
    } else {
      LsystemExpression condition = LsystemExpression::parse(cursor_, names);
      if (!condition.is_constant() || constant(condition) == 0.0) {
        production.condition = std::move(condition);
      }
    }
    if (!cursor_.accept(":")) return;
    cursor_.skip_blanks();
    const std::size_t begin = cursor_.position();
    production.weight = LsystemExpression::parse(cursor_, names);
    if (production.weight->is_constant() && !(constant(*production.weight) > 0.0)) {
      refuse_grammar(begin, "a weight must be above 0");
    }
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
      problems_.push_back({text_.size(), "no axiom; add a line such as axiom: A(1)"});
    } else if (rules_.axiom.empty() && problems_.empty()) {
      problems_.push_back({text_.size(), "the axiom is empty"});
    }
    // After other errors, missing parts would only be consequences.
    if (!problems_.empty()) return;
    for (UnreachedProduction& unreached : unreached_productions(rules_)) {
      problems_.push_back({offsets_[unreached.index], std::move(unreached.why)});
    }
  }

  [[noreturn]] void report() {
    std::stable_sort(problems_.begin(), problems_.end(), [](const auto& a, const auto& b) {
      return a.offset < b.offset;
    });
    const auto place_of = [this](const GrammarProblem& problem) {
      return Place{.file = rules_.file,
                   .line = text_.line_of(problem.offset),
                   .column = fmt::format("column {}", text_.column_of(problem.offset))};
    };
    std::string message = problems_.front().message;
    for (std::size_t i = 1; i < problems_.size(); ++i) {
      message += '\n' + describe(place_of(problems_[i]), problems_[i].message);
    }
    if (problems_.size() >= kMostProblems) message += "\nThere may be more errors.";
    throw InputError(message, place_of(problems_.front()));
  }

  /// The rules that depend on all statements.
  void finish() {
    const std::vector<std::string>& alphabet = modules_.alphabet();
    rules_.of_symbol.resize(alphabet.size());
    for (std::size_t i = 0; i < rules_.productions.size(); ++i) {
      const Production& production = rules_.productions[i];
      SymbolRules& of_symbol = rules_.of_symbol[production.symbol];
      of_symbol.productions.push_back(static_cast<std::uint32_t>(i));
      of_symbol.has_weights = of_symbol.has_weights || production.weight.has_value();
    }
    rules_.alphabet = std::make_shared<const std::vector<std::string>>(alphabet);
    rules_.is_random = draws_random_numbers(rules_.axiom) ||
                       std::any_of(rules_.productions.begin(), rules_.productions.end(), is_random);
    // No production rewrites %.
    rules_.cuts = modules_.has_symbol("%");
  }

  GrammarText text_;
  ModuleReader modules_;
  const std::map<std::string, double>& replaced_;
  GrammarRules rules_{};
  std::vector<GrammarProblem> problems_{};
  std::vector<std::size_t> offsets_{};  ///< of productions
  std::set<std::string> set_{};         ///< names of settings
  GrammarCursor cursor_{};              ///< in the current statement
};

}  // namespace

GrammarRules parse_grammar(std::string_view text,
                           const std::string& file,
                           const std::map<std::string, double>& constants) {
  if (text.size() > kLongestText) {
    throw InputError(
        fmt::format("has {} bytes; the limit for a grammar is {}", text.size(), kLongestText),
        {.file = file});
  }
  return GrammarParser(text, file, constants).parse();
}

}  // namespace silvafit::tree
