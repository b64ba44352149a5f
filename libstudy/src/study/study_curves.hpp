// SPDX-License-Identifier: MIT
// Curves of the chosen models over DBH, for the report.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

/// The same curves for five classes of one covariate, with the other columns at their means.
struct ClassCurves {
  std::string covariate{};
  std::vector<double> classes{};     ///< ascending values of the covariate
  std::vector<std::size_t> trees{};  ///< by class: trees to which no other class is nearer
  /// By class, over the grid: least squares with covariates, and mixed model with b = 0. NaN
  /// without such a model.
  std::vector<std::vector<double>> covariates{};
  std::vector<std::vector<double>> population{};
};

/// The ends of the 95 % confidence intervals of a curve, over the grid.
struct CurveBand {
  std::vector<double> low{};
  std::vector<double> high{};
};

/// A response against DBH with the other columns at their means.
struct Curves {
  std::map<std::string, double> held_at{};
  std::vector<double> dbh_cm{};  ///< the common grid
  std::vector<double> h_m{};     ///< height at each DBH, for models that use it; else empty
  std::vector<double> ols{};
  std::vector<double> population{};  ///< mixed model with b = 0
  CurveBand ols_band{};
  CurveBand population_band{};                         ///< of f(beta); empty without a mixed model
  std::map<std::string, std::vector<double>> plots{};  ///< by plot, NaN outside its range of DBH
  std::vector<ClassCurves> by_class{};                 ///< of each covariate of the chosen model
};

/// Columns besides DBH and height that the chosen model of the last level uses.
std::vector<std::string> covariates_of(const ResponseStudy& result);

/// Empty if the result has no least-squares fit. Height comes from the study's own height model
/// of the species, or is its mean without one.
std::optional<Curves> curves_of(const ResponseStudy& result, const StudyRecord& record);

}  // namespace silvafit::study
