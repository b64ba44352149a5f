// SPDX-License-Identifier: MIT
// Correlation of the residuals of a group: in time, in space, or of its observations in general.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// A structure of correlations (R nlme's corStruct). Observations of different groups are
/// independent given the random effects.
struct Correlation {
  enum class Kind {
    kAr1,                ///< phi^|t - s|, t integers
    kCar1,               ///< phi^|t - s|, phi > 0
    kArma,               ///< autoregressive moving average, t integers
    kCompoundSymmetry,   ///< rho
    kSymmetric,          ///< one for each pair of times
    kExponential,        ///< exp(-d/range)
    kGaussian,           ///< exp(-(d/range)^2)
    kSpherical,          ///< 1 - 1.5 d/range + 0.5 (d/range)^3 for d < range, else 0
    kRationalQuadratic,  ///< 1 / (1 + (d/range)^2)
    kLinear,             ///< 1 - d/range for d < range, else 0
  };
  Kind kind = Kind::kAr1;
  /// The time or the coordinates; none: the order of the rows.
  std::vector<std::string> columns{};
  /// Column of the groups within those of the random effects; empty: these, or all rows.
  std::string group{};
  bool has_nugget = false;  ///< correlations are (1 - nugget) times those of the structure
  int autoregressive = 0;   ///< order p of an ARMA
  int moving_average = 0;   ///< order q

  /// "car1(age)", "arma(1, 1, time | plot)", "exponential(x, y; nugget)", ...
  std::string text() const;
  bool operator==(const Correlation&) const = default;
};

/// Reads a structure as Correlation::text() writes it.
/// \throws FormulaError with the position of the error
Correlation parse_correlation(std::string_view text);

/// A structure with its parameters, by R nlme's definitions.
struct CorrelationEstimate {
  Correlation correlation{};
  std::vector<std::string> names{};  ///< phi, rho, range, nugget, phi1, theta1, cor(1, 2), ...
  Eigen::VectorXd values{};
  /// The times of a symmetric structure in ascending order, to which its names refer.
  std::vector<double> times{};
  /// The length of range and time that counts as one in the search: any positive value.
  double unit = 1.0;
  /// rho of compound symmetry is above -1/(largest - 1), largest that of the groups' sizes.
  Eigen::Index largest = 2;
};

}  // namespace silvafit::fit
