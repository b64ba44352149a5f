// SPDX-License-Identifier: MIT
// How structural indices are computed, as study.json and model libraries say it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace silvafit::study {

/// Settings of stand::StructuralUnitOptions in the words of the files and of the command line. What
/// is not set has the default there.
struct UnitSettings {
  std::optional<std::string> per{};  ///< plot or stand
  std::optional<std::size_t> neighbors{};
  std::optional<std::vector<std::string>> alpha{};  ///< limit angles: `72`, `SM=60`
  std::optional<std::string> dominance{};           ///< dbh, h or cw
  std::optional<std::string> crowding{};            ///< mean or facing
  std::optional<double> competition_radius_m{};
  std::optional<std::string> open_grown{};  ///< an expression of dbh
};

}  // namespace silvafit::study
