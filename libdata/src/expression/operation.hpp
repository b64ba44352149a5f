// SPDX-License-Identifier: MIT
// The operations that expressions are made of, their names, what each does to single values, and
// advice on functions that formulas do not have.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::data {

enum class Operation : std::uint8_t {
  kConstant,
  kVariable,
  kAdd,
  kSubtract,
  kMultiply,
  kLimitProduct,  ///< product, but 0 times anything, even infinity or infinity - infinity, is 0:
                  ///< for derivatives at the boundary of a domain
  kDivide,
  kPower,
  kNegate,
  kLess,
  kLessEqual,
  kEqual,
  kAnd,
  kOr,
  kNot,
  kMin,
  kMax,
  kIfElse,
  kExp,
  kLog,
  kLogFloored,  ///< log, but finite at 0: in d x^y / dy = x^y log x, which is 0 at x = 0
  kLog10,
  kLog2,
  kLog1p,
  kExpm1,
  kSqrt,
  kAbs,
  kSign,
  kSin,
  kCos,
  kTan,
  kAsin,
  kAcos,
  kAtan,
  kSinh,
  kCosh,
  kTanh,
};

/// A function that can be called in a formula.
struct Function {
  std::string_view name{};
  Operation operation{};
  int arguments = 1;
};

/// The function of that name, if there is one. `pow` is the power operator.
std::optional<Function> find_function(std::string_view name);
/// The names of all functions that a formula can use.
std::vector<std::string> function_names();

/// The name under which an operation is called as a function; empty for operators.
std::string_view function_name(Operation operation);

/// The value of an operation on numbers; unused arguments are ignored.
double apply(Operation operation, double a, double b, double c);

/// The rest of the message "unknown function 'NAME'": what to write instead, or a function with a
/// similar name.
std::string advice_on_function(std::string_view name);

}  // namespace silvafit::data
