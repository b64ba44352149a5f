// SPDX-License-Identifier: MIT
// Conversion of variance functions between internal parameters for optimizers and reported ones.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "model/correlated_rows.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"
#include "silvafit/fit/variance_function.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {

/// The residual scale g(v) of each observation and its derivatives.
struct ResidualScale {
  Eigen::ArrayXd weight{};           ///< (N) g^-2
  Eigen::ArrayXXd log_derivative{};  ///< (N x m) d log g / d internal parameter
  double sum_log = 0.0;              ///< sum of log g
};

/// The data that variance functions read from N observations.
struct VarianceData {
  VectorXd response{};  ///< (N) magnitudes like those of the fitted values
  std::map<std::string, VectorXd, std::less<>> columns{};  ///< (N) by name
  std::vector<NonlinearModel::Strata> strata{};
  /// v0 of each factor; empty: that of these observations.
  std::vector<TypicalValue> typical{};
  std::shared_ptr<const CorrelatedRows> correlated{};  ///< null: independent residuals

  /// \param known  as CorrelatedRows::of() has it
  static VarianceData of(const NonlinearModel& model, const CorrelationEstimate* known = nullptr);
};

/// A variance function, and the correlation of the residuals if the data have one, with internal
/// parameters that are of order one and, without strata, nearly uncorrelated with sigma: v is taken
/// relative to its typical value, so that g is about 1 for any delta. With strata, sigma must have
/// the same meaning in each: their factors are used as they are defined. The files of the kinds
/// define their internal parameters.
class VarianceModel {
 public:
  /// A quantity in log g: one number, or one per stratum.
  struct Quantity {
    VarianceQuantity kind = VarianceQuantity::kDelta;
    std::string name{};          ///< of the variable in log_scale()
    std::size_t factor = 0;      ///< of the function
    int strata = -1;             ///< index into VarianceData::strata, -1 for one number
    Index first = 0;             ///< internal parameter of its first estimated stratum
    Index count = 1;             ///< estimated strata
    bool has_reference = false;  ///< the first stratum is 0 and not estimated
    double start = 0.0;
    double at_constant = 0.0;  ///< its value for a constant variance
  };

  VarianceModel(const VarianceFunction& function, VarianceData data);

  /// Number of internal parameters, m: those of g, then those of the correlation.
  Index parameter_count() const { return scale_parameter_count_ + correlation_count(); }
  const CorrelatedRows* correlated() const { return data_.correlated.get(); }
  Index correlation_count() const {
    return correlated() == nullptr ? 0 : correlated()->structure().parameter_count();
  }
  VectorXd correlation_part(const VectorXd& parameters) const {
    return parameters.tail(correlation_count());
  }
  /// Internal parameters at the start.
  VectorXd start() const;
  /// The same, and others: a constant plus a power may have maxima at steep powers of both signs.
  std::vector<VectorXd> starts() const;
  /// Internal parameters of a constant variance, as far as no other value is held.
  VectorXd constant() const;

  /// log g as an expression of the fitted value, columns and quantities.
  const data::Expression& log_scale() const { return log_scale_; }
  static const std::string& fitted_name();
  const std::vector<Quantity>& quantities() const { return quantities_; }
  const VarianceData& data() const { return data_; }
  /// Whether g depends on the fitted value.
  bool uses_fitted() const;

  /// \param fitted      (N) fitted values
  /// \param parameters  (m) internal
  ResidualScale scale(const VectorXd& fitted,
                      const VectorXd& parameters,
                      bool with_derivatives) const;

  /// The typical |v| of a factor of the function, v0.
  const TypicalValue& typical_value(std::size_t factor) const { return typical_[factor]; }
  /// The same of all factors.
  const std::vector<TypicalValue>& typical_values() const { return typical_; }

  /// Number of observations whose |v| is so small that it was floored.
  Index floored(const VectorXd& fitted) const;

  VarianceEstimate estimate(const VectorXd& parameters) const;
  /// Internal parameters of an estimate; NaN if it is NaN.
  VectorXd parameters(const VarianceEstimate& estimate) const;
  /// The same, moved inside the range if they are at a bound: there the likelihood is flat by
  /// symmetry, and a search would not leave it.
  VectorXd inside_range(const VarianceEstimate& estimate) const;
  /// The factor from the internal residual scale to nlme's sigma; a factor whose constant is
  /// infinite counts as 1.
  double sigma_factor(const VectorXd& parameters) const;
  /// The logarithm of the internal residual scale of an estimate with nlme's sigma.
  double log_scale_of(const VarianceEstimate& estimate, double sigma) const;

 private:
  class FactorTerms;

  /// Sets the correlation's parameters: those of an estimate, or without one of a start.
  void set_correlation(const CorrelationEstimate* estimate, VectorXd& parameters) const;

  /// A variable for an estimated quantity.
  data::Expression quantity(std::size_t factor,
                            VarianceQuantity kind,
                            double start,
                            double at_constant);
  /// (N) the variable of a factor; the response instead of the fitted value.
  const VectorXd& values_of(const VarianceFactor& factor) const;
  int strata_index(const VarianceFactor& factor) const;
  /// Values of a quantity by stratum, a single one without strata.
  VectorXd values(int quantity, const VectorXd& parameters) const;
  VarianceFactorEstimate factor_estimate(std::size_t factor, const VectorXd& parameters) const;
  /// The logarithm of g over the internal g.
  double log_offset(const VarianceEstimate& estimate) const;

  VarianceFunction function_;
  VarianceData data_;
  std::vector<TypicalValue> typical_;  ///< typical |v| of each factor
  std::vector<Quantity> quantities_;
  Index scale_parameter_count_ = 0;
  data::Expression log_scale_;
  data::Program value_program_;
  data::Program derivative_program_;
};

}  // namespace silvafit::fit
