// SPDX-License-Identifier: MIT
#include "expression/function_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "expression/expression_parser.hpp"
#include "expression/operation.hpp"
#include "silvafit/base/near_names.hpp"

namespace silvafit::data {
namespace {

/// A self-starting model of R's package stats: its arguments, and its formula of their numbers.
struct SelfStart {
  std::string_view name{};
  std::array<std::string_view, 5> arguments{};
  std::string_view formula{};

  std::size_t size() const {
    return static_cast<std::size_t>(std::ranges::find(arguments, std::string_view()) -
                                    arguments.begin());
  }
};

constexpr std::array kSelfStarts = {
    SelfStart{"SSasymp", {"input", "Asym", "R0", "lrc"}, "%2 + (%3 - %2)*exp(-exp(%4)*%1)"},
    SelfStart{"SSasympOff", {"input", "Asym", "lrc", "c0"}, "%2*(1 - exp(-exp(%3)*(%1 - %4)))"},
    SelfStart{"SSasympOrig", {"input", "Asym", "lrc"}, "%2*(1 - exp(-exp(%3)*%1))"},
    SelfStart{"SSbiexp",
              {"input", "A1", "lrc1", "A2", "lrc2"},
              "%2*exp(-exp(%3)*%1) + %4*exp(-exp(%5)*%1)"},
    SelfStart{"SSfol",
              {"Dose", "input", "lKe", "lKa", "lCl"},
              "%1*exp(%3 + %4 - %5)*(exp(-exp(%3)*%2) - exp(-exp(%4)*%2))/(exp(%4) - exp(%3))"},
    SelfStart{
        "SSfpl", {"input", "A", "B", "xmid", "scal"}, "%2 + (%3 - %2)/(1 + exp((%4 - %1)/%5))"},
    SelfStart{"SSgompertz", {"x", "Asym", "b2", "b3"}, "%2*exp(-%3*%4^%1)"},
    SelfStart{"SSlogis", {"input", "Asym", "xmid", "scal"}, "%2/(1 + exp((%3 - %1)/%4))"},
    SelfStart{"SSmicmen", {"input", "Vm", "K"}, "%2*%1/(%3 + %1)"},
    SelfStart{"SSweibull", {"x", "Asym", "Drop", "lrc", "pwr"}, "%2 - %3*exp(-exp(%4)*%1^%5)"},
};

struct Replacement {
  std::string_view function{};
  std::string_view advice{};
};
constexpr std::string_view kSplines = "write the powers with their parameters, b*x + c*x^2";
constexpr std::string_view kFactors =
    "factors and terms of R belong into a sub-model, such as `parameters=a ~ factor(x)`";
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
    Replacement{"as.factor", kFactors},
    Replacement{"interaction", kFactors},
    Replacement{"scale", "write the numbers, (x - 20)/5"},
    Replacement{"pmin", "write min()"},
    Replacement{"pmax", "write max()"},
};

/// Names and numbers need no parentheses inside other operations.
std::string as_operand(std::string_view argument) {
  const bool is_plain = std::ranges::all_of(argument, is_name_byte) || argument[0] == '`';
  return is_plain ? std::string(argument) : fmt::format("({})", argument);
}

/// \param arguments  as many as the model has
std::string formula_of(const SelfStart& model, const std::vector<std::string>& arguments) {
  std::string text;
  for (std::size_t i = 0; i < model.formula.size(); ++i) {
    if (model.formula[i] != '%') {
      text += model.formula[i];
      continue;
    }
    text += as_operand(arguments[static_cast<std::size_t>(model.formula[++i] - '1')]);
  }
  return text;
}

std::string advice_on_self_start(const SelfStart& model, std::vector<std::string> arguments) {
  const bool is_complete = arguments.size() == model.size() &&
                           std::ranges::none_of(arguments, [](const std::string& text) {
                             return text.empty() || text.find('=') != std::string::npos;
                           });
  if (!is_complete) {
    arguments.assign(model.arguments.begin(), model.arguments.begin() + model.size());
  }
  return fmt::format(
      "; write the formula of this self-starting model of R: {}; start values are "
      "not needed",
      formula_of(model, arguments));
}

}  // namespace

std::string advice_on_function(std::string_view name, const std::vector<std::string>& arguments) {
  const auto* const model = std::ranges::find(kSelfStarts, name, &SelfStart::name);
  if (model != kSelfStarts.end()) return advice_on_self_start(*model, arguments);
  const auto* const known = std::ranges::find(kReplacements, name, &Replacement::function);
  if (known != kReplacements.end()) return fmt::format("; {}", known->advice);
  const bool is_self_start = name.size() > 2 && name.starts_with("SS") && name[2] >= 'a';
  if (is_self_start) {
    return "; write the formula of this self-starting model of R; start values are not needed";
  }
  return did_you_mean(name, function_names());
}

}  // namespace silvafit::data
