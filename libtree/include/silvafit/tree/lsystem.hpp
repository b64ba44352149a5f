// SPDX-License-Identifier: MIT
// Parametric L-systems: a text grammar, and the strings of modules that it derives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// Limits after which a grammar stops with an error.
struct LsystemLimits {
  std::size_t modules = 2'000'000;  ///< in one string; four times as many parameters are allowed
  std::size_t depth = 1000;         ///< nested branches of a string that is drawn
  /// Of a derivation: modules rewritten and added, productions tried, steps of expressions. So many
  /// take some 5 s.
  std::size_t operations = 500'000'000;
};

/// The largest number of iterations of a grammar.
inline constexpr int kMostIterations = 1000;

/// Defaults of turtle symbols without parameters, and the start of the turtle.
struct TurtleSettings {
  double angle_deg = 30.0;
  double length = 1.0;
  double width = 0.1;        ///< diameter at the start, in units of length
  double width_ratio = 0.7;  ///< factor by which `!` without a parameter reduces the diameter
  Point tropism{0.0, 0.0, -1.0};
  double elasticity = 0.0;
};

/// Modules in a row: symbols with their parameters.
class ModuleString {
 public:
  /// \param alphabet  names of symbols; a symbol is its index
  explicit ModuleString(std::shared_ptr<const std::vector<std::string>> alphabet)
      : alphabet_(std::move(alphabet)) {}

  std::size_t size() const { return entries_.size(); }
  std::uint32_t symbol(std::size_t i) const { return entries_[i].symbol; }
  const std::string& name(std::size_t i) const { return (*alphabet_)[entries_[i].symbol]; }
  std::span<const double> parameters(std::size_t i) const {
    const std::size_t first = entries_[i].first;
    const std::size_t end = i + 1 < entries_.size() ? entries_[i + 1].first : parameters_.size();
    return {parameters_.data() + first, end - first};
  }
  const std::vector<std::string>& alphabet() const { return *alphabet_; }

  /// The number of modules with this name, for any parameters.
  std::size_t count(std::string_view name) const;
  /// In the notation of grammars: F(1)[+(45)A(0.5)].
  std::string text() const;
  /// One module in that notation.
  std::string text(std::size_t i) const;

  /// Appends a module without parameters.
  void add(std::uint32_t symbol) {
    entries_.push_back({symbol, static_cast<std::uint32_t>(parameters_.size())});
  }
  /// Appends a parameter to the last module.
  void add_parameter(double value) { parameters_.push_back(value); }
  std::size_t parameter_count() const { return parameters_.size(); }
  void clear() {
    entries_.clear();
    parameters_.clear();
  }

 private:
  struct Entry {
    std::uint32_t symbol;
    std::uint32_t first;  ///< its first parameter
  };

  std::shared_ptr<const std::vector<std::string>> alphabet_;
  std::vector<Entry> entries_;
  std::vector<double> parameters_;
};

struct GrammarRules;

/// A parametric L-system G = (V, P, w, R): alphabet, parameters, axiom and productions
/// `predecessor : condition -> successor`. A module that no production matches does not change.
///
/// The language: docs/tree-builders.md. Immutable and cheap to copy; safe to share among threads.
/// Source: Prusinkiewicz and Lindenmayer 1990, The Algorithmic Beauty of Plants, section 1.10.
class Grammar {
 public:
  /// \param file       name for messages
  /// \param constants  replace the values that the text #defines
  /// \throws InputError with file, line and column of the first error, and of up to 19 others;
  /// UsageError if a constant is not #defined in the text or not finite
  static Grammar parse(std::string_view text,
                       const std::string& file,
                       const std::map<std::string, double>& constants = {});
  /// \throws InputError if the file cannot be read, and as parse()
  static Grammar load(const std::filesystem::path& file,
                      const std::map<std::string, double>& constants = {});

  const std::string& file() const;
  /// As set in the grammar; 0 if not set.
  int iterations() const;
  const TurtleSettings& turtle() const;
  /// Whether strings depend on random numbers.
  bool is_random() const;
  /// By name, after replacement.
  const std::map<std::string, double, std::less<>>& constants() const;

  /// The string after this number of steps, each of which rewrites all modules at once.
  /// \param iterations  in [0, kMostIterations]; default: as set in the grammar
  /// \throws InputError with the line of the production, the module and the step if a parameter is
  /// not finite, weights are not positive, productions with and without weight match the same
  /// module, or a limit is exceeded; UsageError if iterations are out of range
  ModuleString derive(Random& random,
                      std::optional<int> iterations = {},
                      const LsystemLimits& limits = {}) const;

 private:
  explicit Grammar(std::shared_ptr<const GrammarRules> rules) : rules_(std::move(rules)) {}

  std::shared_ptr<const GrammarRules> rules_;
};

}  // namespace silvafit::tree
