// SPDX-License-Identifier: MIT
// The self-starting models of R's package stats, which formulas may use as functions.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace silvafit::data {

/// A model by its arguments, and its formula of their numbers from %1.
struct SelfStartingModel {
  std::string_view name{};
  std::array<std::string_view, 5> arguments{};  ///< the rest is empty
  std::string_view formula{};

  std::size_t size() const;
  /// The number of an argument from 0; size() if there is none of this name.
  std::size_t place_of(std::string_view argument) const;
  /// "SSlogis(input, Asym, xmid, scal)"
  std::string call() const;
};

/// Null if there is no model of this name.
const SelfStartingModel* find_self_starting_model(std::string_view name);

}  // namespace silvafit::data
