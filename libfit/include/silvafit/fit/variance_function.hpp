// SPDX-License-Identifier: MIT
// Variance functions: the residual standard deviation by the fitted value or by columns.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/correlation.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// One factor of the residual standard deviation, as a function of v, the fitted value or a column
/// (R nlme's definitions): exp(delta v); |v|^delta; constant + |v|^delta; or a ratio to the first
/// stratum.
struct VarianceFactor {
  enum class Kind { kExponential, kPower, kConstantPlusPower, kStratum };
  Kind kind = Kind::kPower;
  std::string column{};              ///< empty: the fitted value
  std::string stratum{};             ///< column whose values have separate parameters; empty: none
  std::optional<double> delta{};     ///< held at this value, not estimated
  std::optional<double> constant{};  ///< held at this value, not estimated

  /// Estimated parameters of one stratum: at most 1, 1, 2, 1.
  int parameter_count() const;
  /// "power", "power(dbh)", "power(fitted | species)", "power(dbh, delta = 0.5)", ...
  std::string text() const;
};

/// A product of factors; none means a constant variance.
struct VarianceFunction {
  std::vector<VarianceFactor> factors{};

  bool is_constant() const { return factors.empty(); }
  /// Number of estimated parameters if no factor has strata.
  int parameter_count() const;
  /// "none", "power", "stratum(species) * power", ...
  std::string text() const;
};

/// Reads none, or factors joined by `*`: exponential, power, constant-plus-power, each with a
/// column if not of the fitted value, strata and held parameters in parentheses as in
/// `power(dbh | species, delta = 0.5)`; and stratum(column).
/// \throws FormulaError with the position of the error
VarianceFunction parse_variance_function(std::string_view text);

/// A factor with its parameters, one value per stratum (a single one without strata).
struct VarianceFactorEstimate {
  VarianceFactor factor{};
  std::vector<std::string> strata{};  ///< labels; one empty label without strata
  Eigen::VectorXd delta{};            ///< exponent or rate; empty for strata
  /// Of constant-plus-power; infinite if it has become a constant variance.
  Eigen::VectorXd constant{};
  Eigen::VectorXd ratio{};  ///< of stratum(): to the first stratum, which has 1
};

/// The estimated parameters of the residuals' variance function and correlation, by R nlme's
/// definitions.
struct VarianceEstimate {
  std::vector<VarianceFactorEstimate> factors{};
  std::optional<CorrelationEstimate> correlation{};

  VarianceFunction function() const;
  /// The exponent or rate of a function of one factor without strata, else NaN.
  double delta() const;
  /// The constant of constant-plus-power as the only factor without strata, else NaN.
  double constant() const;
  /// A function with unknown parameters: those that are not held are NaN, without strata.
  static VarianceEstimate missing(const VarianceFunction& function);
};

/// (N) the residual standard deviation of each row relative to sigma: the product of the factors.
/// A constant-plus-power whose constant is infinite is 1. NaN if a value is missing or its stratum
/// is not known.
/// \param fitted  (N) fitted values of the table's rows
/// \throws UsageError if a column is missing
Eigen::VectorXd relative_sd(const VarianceEstimate& estimate,
                            const Eigen::Ref<const Eigen::VectorXd>& fitted,
                            const data::Table& table);

}  // namespace silvafit::fit
