// SPDX-License-Identifier: MIT
#include "expression/operation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "silvafit/base/near_names.hpp"

namespace silvafit::data {

namespace {

constexpr std::array kFunctions = {
    Function{"exp", Operation::kExp, 1},
    Function{"log", Operation::kLog, 1},
    Function{"log_floored", Operation::kLogFloored, 1},
    Function{"log10", Operation::kLog10, 1},
    Function{"log2", Operation::kLog2, 1},
    Function{"log1p", Operation::kLog1p, 1},
    Function{"expm1", Operation::kExpm1, 1},
    Function{"sqrt", Operation::kSqrt, 1},
    Function{"abs", Operation::kAbs, 1},
    Function{"sign", Operation::kSign, 1},
    Function{"sin", Operation::kSin, 1},
    Function{"cos", Operation::kCos, 1},
    Function{"tan", Operation::kTan, 1},
    Function{"asin", Operation::kAsin, 1},
    Function{"acos", Operation::kAcos, 1},
    Function{"atan", Operation::kAtan, 1},
    Function{"sinh", Operation::kSinh, 1},
    Function{"cosh", Operation::kCosh, 1},
    Function{"tanh", Operation::kTanh, 1},
    Function{"pow", Operation::kPower, 2},
    Function{"min", Operation::kMin, 2},
    Function{"max", Operation::kMax, 2},
    Function{"ifelse", Operation::kIfElse, 3},
};

double as_number(bool truth) { return truth ? 1.0 : 0.0; }

// A result that depends on a missing value is missing; `false && missing` and `true || missing` do
// not depend on it (Kleene's logic, as in R).
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

bool is_true(double a) { return a != 0.0 && !std::isnan(a); }

double compared(bool truth, double a, double b) {
  return std::isnan(a) || std::isnan(b) ? kUnknown : as_number(truth);
}

double both(double a, double b) {
  if (a == 0.0 || b == 0.0) return 0.0;
  return std::isnan(a) || std::isnan(b) ? kUnknown : 1.0;
}

double either(double a, double b) {
  if (is_true(a) || is_true(b)) return 1.0;
  return std::isnan(a) || std::isnan(b) ? kUnknown : 0.0;
}

double chosen(double condition, double a, double b) {
  if (std::isnan(condition)) return kUnknown;
  return condition != 0.0 ? a : b;
}

double limit_product(double a, double b) { return a == 0.0 || b == 0.0 ? 0.0 : a * b; }

double sign_of(double a) {
  if (std::isnan(a)) return a;
  return as_number(a > 0.0) - as_number(a < 0.0);
}

}  // namespace

std::optional<Function> find_function(std::string_view name) {
  const auto* entry = std::ranges::find(kFunctions, name, &Function::name);
  if (entry == kFunctions.end()) return std::nullopt;
  return *entry;
}

std::vector<std::string> function_names() {
  std::vector<std::string> names;
  for (const Function& function : kFunctions) {
    // The floored logarithm is for derivatives.
    if (function.operation != Operation::kLogFloored) names.emplace_back(function.name);
  }
  return names;
}

std::string_view function_name(Operation operation) {
  if (operation == Operation::kPower) return {};
  const auto* entry = std::ranges::find(kFunctions, operation, &Function::operation);
  return entry == kFunctions.end() ? std::string_view() : entry->name;
}

double apply(Operation operation, double a, double b, double c) {
  switch (operation) {
    case Operation::kConstant:
    case Operation::kVariable:
      return a;
    case Operation::kAdd:
      return a + b;
    case Operation::kSubtract:
      return a - b;
    case Operation::kMultiply:
      return a * b;
    case Operation::kLimitProduct:
      return limit_product(a, b);
    case Operation::kDivide:
      return a / b;
    case Operation::kPower:
      return std::pow(a, b);
    case Operation::kNegate:
      return -a;
    case Operation::kLess:
      return compared(a < b, a, b);
    case Operation::kLessEqual:
      return compared(a <= b, a, b);
    case Operation::kEqual:
      return compared(a == b, a, b);
    case Operation::kAnd:
      return both(a, b);
    case Operation::kOr:
      return either(a, b);
    case Operation::kNot:
      return compared(a == 0.0, a, a);
    case Operation::kMin:
      return b < a || std::isnan(b) ? b : a;
    case Operation::kMax:
      return b > a || std::isnan(b) ? b : a;
    case Operation::kIfElse:
      return chosen(a, b, c);
    case Operation::kExp:
      return std::exp(a);
    case Operation::kLog:
      return std::log(a);
    case Operation::kLogFloored:
      return a == 0.0 ? std::log(std::numeric_limits<double>::min()) : std::log(a);
    case Operation::kLog10:
      return std::log10(a);
    case Operation::kLog2:
      return std::log2(a);
    case Operation::kLog1p:
      return std::log1p(a);
    case Operation::kExpm1:
      return std::expm1(a);
    case Operation::kSqrt:
      return std::sqrt(a);
    case Operation::kAbs:
      return std::abs(a);
    case Operation::kSign:
      return sign_of(a);
    case Operation::kSin:
      return std::sin(a);
    case Operation::kCos:
      return std::cos(a);
    case Operation::kTan:
      return std::tan(a);
    case Operation::kAsin:
      return std::asin(a);
    case Operation::kAcos:
      return std::acos(a);
    case Operation::kAtan:
      return std::atan(a);
    case Operation::kSinh:
      return std::sinh(a);
    case Operation::kCosh:
      return std::cosh(a);
    case Operation::kTanh:
      return std::tanh(a);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

namespace {

struct Replacement {
  std::string_view function{};
  std::string_view advice{};
};
constexpr std::string_view kSplines = "write the powers with their parameters, b*x + c*x^2";
constexpr std::string_view kFactors =
    "factors and other terms belong into a sub-model, such as `parameters=a ~ factor(x)`";
constexpr std::array kReplacements = {
    Replacement{"ln", "write log()"},
    Replacement{"power", "write pow(x, b) or x^b"},
    Replacement{"plogis", "write 1/(1 + exp(-x))"},
    Replacement{"logit", "write log(x/(1 - x))"},
    Replacement{"qlogis", "write log(x/(1 - x))"},
    Replacement{"offset", "write its argument, which has no parameter"},
    Replacement{"poly", kSplines},
    Replacement{"ns", kSplines},
    Replacement{"bs", kSplines},
    Replacement{"s", kSplines},
    Replacement{"te", kSplines},
    Replacement{"factor", kFactors},
    Replacement{"C", kFactors},
    Replacement{"as.factor", kFactors},
    Replacement{"interaction", kFactors},
    Replacement{"scale", "write the numbers, (x - 20)/5"},
    Replacement{"pmin", "write min()"},
    Replacement{"pmax", "write max()"},
};

}  // namespace

std::string advice_on_function(std::string_view name) {
  // Formulas of Python's packages.
  if (name.starts_with("np.")) return fmt::format("; write {}()", name.substr(3));
  const auto* const known = std::ranges::find(kReplacements, name, &Replacement::function);
  if (known != kReplacements.end()) return fmt::format("; {}", known->advice);
  const bool is_self_start = name.size() > 2 && name.starts_with("SS") && name[2] >= 'a';
  if (is_self_start) {
    return "; write the formula of this self-starting model of R; start values are not needed";
  }
  return did_you_mean(name, function_names());
}

}  // namespace silvafit::data
