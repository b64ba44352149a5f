// SPDX-License-Identifier: MIT
// Deriving strings from a grammar.
#include "silvafit/tree/lsystem.hpp"

#include <fmt/format.h>

#include <cmath>

#include "lsystem/lsystem_rules.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

/// Rewrites a string step by step.
class Derivation {
 public:
  Derivation(const GrammarRules& rules, Random& random, const LsystemLimits& limits)
      : rules_(rules),
        random_(random),
        limits_(limits),
        string_(rules.alphabet),
        next_(rules.alphabet) {}

  ModuleString run(int iterations) {
    append(rules_.axiom, nullptr, rules_.axiom_line);
    cut(string_from_next());
    for (step_ = 1; step_ <= iterations; ++step_) {
      next_.clear();
      rewrite();
      cut(string_from_next());
    }
    return std::move(string_);
  }

 private:
  ModuleString& string_from_next() {
    std::swap(string_, next_);
    return string_;
  }

  void rewrite() {
    for (at_ = 0; at_ < string_.size(); ++at_) {
      const Production* production = matching();
      if (production == nullptr) {
        copy();
      } else {
        append(production->successor, string_.parameters(at_).data(), production->line);
      }
      check_size(production == nullptr ? rules_.axiom_line : production->line);
      check_work();
    }
  }

  void copy() {
    next_.add(string_.symbol(at_));
    for (const double parameter : string_.parameters(at_)) next_.add_parameter(parameter);
  }

  // ---- Which production -----------------------------------------------------------------------

  bool matches(const Production& production, std::span<const double> parameters) {
    ++operations_;
    return production.parameter_count == parameters.size() &&
           (!production.condition ||
            value(*production.condition, parameters.data(), production.line, "the condition") !=
                0.0);
  }

  /// The first that matches or, with weights, one of all that match.
  const Production* matching() {
    const SymbolRules& rules = rules_.of_symbol[string_.symbol(at_)];
    if (rules.has_weights) return chosen(rules);
    for (const std::uint32_t index : rules.productions) {
      const Production& production = rules_.productions[index];
      if (matches(production, string_.parameters(at_))) return &production;
    }
    return nullptr;
  }

  const Production* chosen(const SymbolRules& rules) {
    const auto parameters = string_.parameters(at_);
    candidates_.clear();
    double sum = 0.0;
    const Production* without_weight = nullptr;
    for (const std::uint32_t index : rules.productions) {
      const Production& production = rules_.productions[index];
      if (!matches(production, parameters)) continue;
      if (!production.weight) {
        if (without_weight == nullptr) without_weight = &production;
        continue;
      }
      const double weight =
          value(*production.weight, parameters.data(), production.line, "the weight");
      if (!(weight > 0.0)) {
        fail(production.line,
             fmt::format(
                 "the weight {} is {}; it must be above 0", production.weight->text(), weight));
      }
      sum += weight;
      candidates_.emplace_back(&production, sum);
    }
    if (candidates_.empty()) return without_weight;
    if (without_weight != nullptr) {
      fail(without_weight->line,
           fmt::format(
               "this production and that of line {} match the same module, but only the latter has "
               "a weight; give both a weight, or conditions that exclude each other",
               candidates_.front().first->line));
    }
    const double drawn = random_.uniform(0.0, sum);
    for (const auto& [production, up_to] : candidates_) {
      if (drawn < up_to) return production;
    }
    return candidates_.back().first;
  }

  // ---- What it becomes ------------------------------------------------------------------------

  void append(const std::vector<SuccessorModule>& modules,
              const double* parameters,
              std::size_t line) {
    operations_ += modules.size();
    for (const SuccessorModule& module : modules) {
      next_.add(module.symbol);
      for (const LsystemExpression& expression : module.parameters) {
        next_.add_parameter(value(expression, parameters, line, "a parameter"));
      }
    }
  }

  double value(const LsystemExpression& expression,
               const double* parameters,
               std::size_t line,
               const char* what) {
    operations_ += expression.size();
    try {
      return expression.value(parameters, random_);
    } catch (const ArithmeticProblem& problem) {
      fail(line, fmt::format("{}, {}, is not valid: {}", what, expression.text(), problem.message));
    }
  }

  /// Removes everything after a % in its branch, and the % itself.
  void cut(ModuleString& string) {
    if (!rules_.cuts) return;
    operations_ += string.size();
    ModuleString kept(rules_.alphabet);
    std::size_t skipped_depth = 0;
    bool skips = false;
    for (std::size_t i = 0; i < string.size(); ++i) {
      const std::string& name = string.name(i);
      const char c = name.size() == 1 ? name.front() : '\0';
      if (skips && c == '[') ++skipped_depth;
      if (skips && c == ']' && skipped_depth-- == 0) skips = false;
      if (!skips && c == '%') {
        skips = true;
        skipped_depth = 0;
      }
      if (skips) continue;
      kept.add(string.symbol(i));
      for (const double parameter : string.parameters(i)) kept.add_parameter(parameter);
    }
    string = std::move(kept);
  }

  // ---- Limits ---------------------------------------------------------------------------------

  [[noreturn]] void fail(std::size_t line, const std::string& message) const {
    std::string where = fmt::format("step {}", step_);
    if (step_ > 0 && at_ < string_.size()) where += ", " + string_.text(at_);
    throw InputError(where + ": " + message, {.file = rules_.file, .line = line});
  }

  void check_size(std::size_t line) const {
    if (next_.size() <= limits_.modules && next_.parameter_count() <= 4 * limits_.modules) return;
    fail(line,
         fmt::format("the string exceeds {} modules or {} parameters; use fewer iterations, or a "
                     "condition that ends the growth",
                     limits_.modules,
                     4 * limits_.modules));
  }

  /// Counted, not timed, so that a grammar that works on one machine works on all.
  void check_work() {
    if (++operations_ <= limits_.operations) return;
    fail(rules_.axiom_line,
         fmt::format("deriving the grammar takes more than {} operations; use fewer iterations",
                     limits_.operations));
  }

  const GrammarRules& rules_;
  Random& random_;
  const LsystemLimits& limits_;
  ModuleString string_;
  ModuleString next_;
  std::vector<std::pair<const Production*, double>> candidates_{};
  int step_ = 0;
  std::size_t at_ = 0;
  std::size_t operations_ = 0;
};

}  // namespace

std::size_t ModuleString::count(std::string_view name) const {
  std::size_t number = 0;
  for (std::size_t i = 0; i < size(); ++i) number += this->name(i) == name ? 1 : 0;
  return number;
}

std::string ModuleString::text(std::size_t i) const {
  std::string text = name(i);
  const auto values = parameters(i);
  for (std::size_t k = 0; k < values.size(); ++k) {
    text += fmt::format("{}{}", k == 0 ? "(" : ", ", values[k]);
  }
  return values.empty() ? text : text + ")";
}

std::string ModuleString::text() const {
  std::string whole;
  for (std::size_t i = 0; i < size(); ++i) whole += text(i);
  return whole;
}

Grammar Grammar::parse(std::string_view text,
                       const std::string& file,
                       const std::map<std::string, double>& constants) {
  return Grammar(std::make_shared<const GrammarRules>(parse_grammar(text, file, constants)));
}

Grammar Grammar::load(const std::filesystem::path& file,
                      const std::map<std::string, double>& constants) {
  return parse(read_file(file, kLongestText), file.string(), constants);
}

const std::string& Grammar::file() const { return rules_->file; }
int Grammar::iterations() const { return rules_->iterations; }
const TurtleSettings& Grammar::turtle() const { return rules_->turtle; }
bool Grammar::is_random() const { return rules_->is_random; }
const std::map<std::string, double, std::less<>>& Grammar::constants() const {
  return rules_->constants;
}

ModuleString Grammar::derive(Random& random,
                             std::optional<int> iterations,
                             const LsystemLimits& limits) const {
  const int steps = iterations.value_or(rules_->iterations);
  if (steps < 0 || steps > kMostIterations) {
    throw UsageError(fmt::format("iterations must be in [0, {}], not {}", kMostIterations, steps));
  }
  return Derivation(*rules_, random, limits).run(steps);
}

}  // namespace silvafit::tree
