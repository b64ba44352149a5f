// SPDX-License-Identifier: MIT
// Curves of the chosen models over DBH, for the report.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/study/study_files.hpp"

namespace silvafit::study {

/// A response against DBH with the other columns held at their means.
struct Curves {
  std::map<std::string, double> held_at{};
  std::vector<double> dbh_cm{};  ///< the common grid
  std::vector<double> h_m{};     ///< height at each DBH, for models that use it; else empty
  std::vector<double> ols{};
  std::vector<double> population{};                    ///< mixed model with b = 0
  std::map<std::string, std::vector<double>> plots{};  ///< by plot, NaN outside its range of DBH
};

/// Nothing if the result has no least-squares fit. Height comes from the study's own height model
/// of the species, or is held at its mean without one.
std::optional<Curves> curves_of(const ResponseStudy& result, const StudyRecord& record);

}  // namespace silvafit::study
