// SPDX-License-Identifier: MIT
#include "expression/function_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "expression/operation.hpp"
#include "silvafit/base/near_names.hpp"

namespace silvafit::data {
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
