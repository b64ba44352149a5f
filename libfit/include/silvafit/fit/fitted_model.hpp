// SPDX-License-Identifier: MIT
// A fit by any method, for output, storage and predictions.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/estimates.hpp"
#include "silvafit/fit/fit_statistics.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/fit/parameter_intervals.hpp"

namespace silvafit::fit {

/// The default method of a specification: lb with random effects, else gnls with a variance
/// function or correlated residuals, else ols.
Method default_method(const ModelSpecification& specification);

/// Smallest and largest value of a data column among the rows of a fit.
struct ColumnRange {
  std::string column{};
  double low = 0.0;
  double high = 0.0;
};

/// The values, in the rows of a fit, of a column that the mean compares with text, such as
/// `species == "SM"`.
struct ColumnLevels {
  std::string column{};
  std::vector<std::string> labels{};  ///< in alphabetical order
};

/// The complete stored fit: model, method, description of the data, and the estimates.
struct FittedModel : Estimates {
  explicit FittedModel(ModelSpecification fitted) : specification(std::move(fitted)) {}

  std::string model{};  ///< id in the catalogue, or empty
  ModelSpecification specification;
  Method method = Method::kOrdinary;
  bool reml = false;          ///< restricted maximum likelihood
  int quadrature_points = 0;  ///< per random effect; 0 for methods other than agq
  Eigen::Index excluded = 0;  ///< rows with missing values
  /// Of the response in the rows used, independent of their order: likelihoods of fits with the
  /// same one are comparable. Empty in files of earlier versions.
  std::string response_fingerprint{};
  std::vector<ColumnRange> ranges{};   ///< of the numeric columns that the mean uses
  std::vector<ColumnLevels> levels{};  ///< unknown in older files

  FitStatistics population{};   ///< of f(beta)
  FitStatistics conditional{};  ///< of f(beta + b); only with random effects
  /// Shares of the variance that fixed, and fixed and random effects explain (Nakagawa and
  /// Schielzeth 2013, Johnson 2014; docs/mixed-effects.md); NaN without random effects.
  double r2_marginal = kNaN;
  double r2_conditional = kNaN;
  std::optional<Intervals> intervals{};  ///< if requested: confidence_intervals()
  double seconds = 0.0;

  /// Whether the uncertainty of the random effects is stored; not in files of earlier versions.
  bool knows_uncertainty() const;
  /// As that of the estimates; NaN unless all groups are within those of the first term.
  double bic_groups() const;
  /// (N) residual standard deviation of a table's rows by the variance function.
  /// \param fitted  (N) fitted values of the rows
  Eigen::VectorXd residual_sd(const Eigen::Ref<const Eigen::VectorXd>& fitted,
                              const data::Table& table) const;
};

/// (p x p) the covariance of the fixed effects. Coefficients without one are treated as known if
/// they were held or published; those that are not identifiable remain NaN.
Eigen::MatrixXd fixed_covariance(const FittedModel& fit);

/// The fit, and the fitted values of each observation.
struct FitResult {
  FittedModel fit;
  std::vector<std::size_t> rows{};       ///< (N) row of the table of each observation
  Eigen::VectorXd fitted_population{};   ///< (N)
  Eigen::VectorXd fitted_conditional{};  ///< (N) equal to the population's without random effects
  Eigen::VectorXd residual_sd{};         ///< (N) standard deviation of the residual
};

/// The bounds of a coefficient, inclusive; see docs/fit-command.md.
struct Bounds {
  double low = -kInfinity;
  double high = kInfinity;
};

struct FitModelOptions {
  /// Unless given: default_method, and focei where that is lb and finds no result.
  std::optional<Method> method{};
  std::map<std::string, double> start{};  ///< by coefficient, optional
  /// An earlier fit of the same specification, or of that with a constant variance, to the same or
  /// other data, if given. The fit starts from its coefficients, covariance and variance parameters
  /// and, by the groups' labels, random effects. Other starts are used only if this one does not
  /// converge. It must live as long as the call.
  const FittedModel* from = nullptr;
  std::map<std::string, double> rule{};           ///< by parameter, from the catalogue
  SearchEffort effort = SearchEffort::kThorough;  ///< of mixed and generalized fits
  int spread_starts = 0;                          ///< further starts of a thorough search
  std::map<std::string, double> fixed{};          ///< coefficients held at a value
  std::map<std::string, Bounds> bounds{};         ///< by coefficient
  int maximum_iterations = 200;                   ///< alternations of lb and gnls
  bool reml = false;                              ///< for lb and gnls; see MixedEffectsOptions
  int quadrature_points = 7;                      ///< for agq, per random effect
  unsigned threads = 1;                           ///< over rows and groups; 0: all cores
  /// Called with one line for each iteration, if given.
  std::function<void(const std::string&)> trace{};
  /// Stops the fit with the exception Stopped, within a few passes over the data, if given.
  std::stop_token stop{};
};

/// Fits a model to the rows of a table without missing values in its columns. Mixed and generalized
/// fits start from the least-squares fit. A failed fit is returned with its convergence message.
/// \throws UsageError if the method does not suit the specification, a start value, a held value or
///   a bound is not for a coefficient; UsageError, InputError, DomainError as NonlinearModel and
///   fit_least_squares; Stopped if the caller has requested it
FitResult fit_model(const ModelSpecification& specification,
                    const data::Table& table,
                    const FitModelOptions& options = {});

}  // namespace silvafit::fit
