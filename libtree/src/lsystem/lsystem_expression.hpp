// SPDX-License-Identifier: MIT
// Arithmetic of grammars: compiled once, evaluated for millions of modules.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "lsystem/lsystem_text.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::tree {

/// The result is not a number: a division by zero, a root of a negative number.
struct ArithmeticProblem {
  std::string message{};
};

/// Names that an expression may use: constants by value, parameters by index.
struct ExpressionNames {
  const std::map<std::string, double, std::less<>>* constants = nullptr;
  std::vector<std::string> parameters{};
};

/// An expression of a production. A Program of libdata computes equal parts once, which random
/// numbers must not be, skips no operand of && and ||, and has blocks of rows where this one takes
/// a module's parameters in place.
class LsystemExpression {
 public:
  /// Reads up to the first character that cannot continue an expression, and stops there.
  /// \throws GrammarProblem
  static LsystemExpression parse(GrammarCursor& cursor, const ExpressionNames& names);

  /// \param parameters  one for each name
  /// \throws ArithmeticProblem
  double value(const double* parameters, Random& random) const {
    return code_.size() == 1 && code_.front().kind == Kind::kNumber ? code_.front().number
                                                                    : run(parameters, random);
  }

  bool is_constant() const { return code_.size() == 1 && code_.front().kind == Kind::kNumber; }
  bool draws_random_numbers() const;
  /// Operations of an evaluation, at most.
  std::size_t size() const { return code_.size(); }
  /// As written.
  const std::string& text() const { return text_; }

  // For the parser, which fills it.
  enum class Kind : std::uint8_t {
    kNumber,
    kParameter,
    kOperation,
    kDraw,         ///< an operation with random numbers
    kSkipIfFalse,  ///< of &&: the following operand is not evaluated
    kSkipIfTrue,   ///< of ||
  };
  using Compute = double (*)(double a, double b, Random& random);
  struct Instruction {
    Kind kind = Kind::kNumber;
    std::uint32_t index =
        0;  ///< of a parameter; number of values of an operation; target of a jump
    double number = 0.0;
    Compute compute = nullptr;
  };

 private:
  friend class ExpressionParser;
  double run(const double* parameters, Random& random) const;

  std::vector<Instruction> code_;
  std::string text_;
};

}  // namespace silvafit::tree
