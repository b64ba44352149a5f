// SPDX-License-Identifier: MIT
// Site index: the dominant height of a stand at a base age, by published curves, which are data.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "silvafit/data/expression.hpp"

namespace silvafit::study {

/// Dominant height at age2 of a stand that has h at an age; an entry of models/site_index.
struct SiteCurve {
  std::string id{};
  std::string title{};  ///< species and region
  std::vector<std::string> species{};
  std::vector<std::string> source{};
  data::Expression height = data::Expression::constant(0.0);  ///< of h, age and age2 [m, years]
  double base_age = 0.0;
  double lowest_age = 0.0;  ///< for which it was made
  double highest_age = 0.0;
  /// Height, age and site index by another program or the publication, for a test.
  std::vector<std::array<double, 3>> reference_points{};

  /// [m]; NaN without an age or a height above 0
  double height_at(double age2, double h_m, double age) const;
  /// The same at the base age; NaN beyond the ages for which the curve was made, too.
  double site_index(double h_m, double age) const {
    return has_age(age) ? height_at(base_age, h_m, age) : NAN;
  }
  bool has_age(double age) const { return age >= lowest_age && age <= highest_age; }
};

/// The curves of `models/site_index`, by id.
/// \throws InputError that names the file and the key, if an entry cannot be used
std::vector<SiteCurve> load_site_curves(const std::filesystem::path& models);

/// \throws UsageError that lists the curves if there is no such one
const SiteCurve& site_curve(const std::vector<SiteCurve>& curves, const std::string& id);

}  // namespace silvafit::study
