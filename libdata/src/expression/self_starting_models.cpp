// SPDX-License-Identifier: MIT
#include "expression/self_starting_models.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace silvafit::data {
namespace {

using Model = SelfStartingModel;

/// The formulas of the R documentation of each model (package stats).
constexpr std::array kModels = {
    Model{"SSasymp", {"input", "Asym", "R0", "lrc"}, "%2 + (%3 - %2)*exp(-exp(%4)*%1)"},
    Model{"SSasympOff", {"input", "Asym", "lrc", "c0"}, "%2*(1 - exp(-exp(%3)*(%1 - %4)))"},
    Model{"SSasympOrig", {"input", "Asym", "lrc"}, "%2*(1 - exp(-exp(%3)*%1))"},
    Model{"SSbiexp",
          {"input", "A1", "lrc1", "A2", "lrc2"},
          "%2*exp(-exp(%3)*%1) + %4*exp(-exp(%5)*%1)"},
    Model{"SSfol",
          {"Dose", "input", "lKe", "lKa", "lCl"},
          "%1*exp(%3 + %4 - %5)*(exp(-exp(%3)*%2) - exp(-exp(%4)*%2))/(exp(%4) - exp(%3))"},
    Model{"SSfpl", {"input", "A", "B", "xmid", "scal"}, "%2 + (%3 - %2)/(1 + exp((%4 - %1)/%5))"},
    Model{"SSgompertz", {"x", "Asym", "b2", "b3"}, "%2*exp(-%3*%4^%1)"},
    Model{"SSlogis", {"input", "Asym", "xmid", "scal"}, "%2/(1 + exp((%3 - %1)/%4))"},
    Model{"SSmicmen", {"input", "Vm", "K"}, "%2*%1/(%3 + %1)"},
    Model{"SSweibull", {"x", "Asym", "Drop", "lrc", "pwr"}, "%2 - %3*exp(-exp(%4)*%1^%5)"},
};

}  // namespace

std::size_t SelfStartingModel::place_of(std::string_view argument) const {
  return static_cast<std::size_t>(
      std::find(arguments.begin(), arguments.begin() + size(), argument) - arguments.begin());
}

std::size_t SelfStartingModel::size() const {
  return static_cast<std::size_t>(std::ranges::find(arguments, std::string_view()) -
                                  arguments.begin());
}

std::string SelfStartingModel::call() const {
  return fmt::format(
      "{}({})", name, fmt::join(arguments.begin(), arguments.begin() + size(), ", "));
}

const SelfStartingModel* find_self_starting_model(std::string_view name) {
  const auto* const found = std::ranges::find(kModels, name, &SelfStartingModel::name);
  return found == kModels.end() ? nullptr : &*found;
}

}  // namespace silvafit::data
