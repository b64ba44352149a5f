// SPDX-License-Identifier: MIT
// Standard errors and intervals of all parameters by refitting to resampled data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The source of the data of a replicate.
enum class Resample {
  kParametric,  ///< random effects and residuals are drawn from the fit, on the same design
  kCases,       ///< whole groups of the outermost grouping are drawn with replacement; variance
                ///< ratios stay relative to the fit's first stratum, and a replicate without it has
                ///< neither ratios nor sigma
};
constexpr std::array<std::string_view, 2> words_of(Resample /*resample*/) {
  return {"parametric", "cases"};
}

struct BootstrapOptions {
  std::size_t replicates = 500;
  Resample resample = Resample::kParametric;
  double level = 0.95;  ///< of the intervals
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< over replicates; 0: all cores
  /// The column of the groups that kCases draws, each of which consists of whole groups of the
  /// random effects. Empty: those of the outermost grouping, single observations without random
  /// effects.
  std::string group{};
  /// Held coefficients, bounds and iterations of the fit, and the stop token. Method, restricted
  /// likelihood and points of quadrature are always those of the fit.
  FitModelOptions refit{};
  /// Called after each replicate, if given, possibly from several threads.
  std::function<void(std::size_t done, std::size_t total)> progress{};
};

struct Interval {
  double low = kNaN;
  double high = kNaN;
};

/// Bootstrap results of one parameter; theta* are its values in the replicates that have one.
struct BootstrapParameter {
  std::string name{};           ///< as in parameter_values()
  double estimate = 0.0;        ///< theta of the fit
  std::size_t replicates = 0;   ///< number of values
  double bias = 0.0;            ///< mean theta* - theta
  double standard_error = 0.0;  ///< standard deviation of theta*
  Interval percentile{};        ///< quantiles of theta*
  Interval basic{};             ///< 2 theta - quantiles of theta*
};

/// Number of replicates with a reason, a text in which numbers are replaced by "#".
struct CountedReason {
  std::string reason{};
  std::size_t replicates = 0;
};

struct Bootstrap {
  Resample resample = Resample::kParametric;
  std::uint64_t seed = 0;
  double level = 0.0;
  std::size_t replicates = 0;
  std::size_t converged = 0;
  /// Those of parameter_values() except ratios of first strata, which are 1 by definition.
  std::vector<BootstrapParameter> parameters{};
  /// (parameters x replicates) all theta*, in the order of the replicates; NaN if there is none.
  Eigen::MatrixXd values{};
  /// Replicates without a converged fit, by convergence message, the most frequent first; they are
  /// not in the results above.
  std::vector<CountedReason> failures{};
  /// Converged boundary (singular) replicates, by the parameter at the boundary; they are included
  /// above.
  std::vector<CountedReason> at_boundary{};
};

/// The fewest values whose order statistics include the limits of an interval: 39 at 95 %.
std::size_t fewest_replicates(double level);

/// Refits a model to resampled data.
///
/// Each replicate has its own random stream, so that results do not depend on the number of
/// threads; it starts from the fit, and without it if that does not converge. Quantiles
/// interpolate between order statistics at (R + 1) p, and are missing beyond these.
/// \param table  the data of the fit
/// \throws UsageError if the fit has not converged, options are out of range, groups are named for
///   the parametric bootstrap, or a group of the random effects is in several of the drawn groups;
///   InputError if a row has no drawn group; as fit_model for the table
/// Source: Davison and Hinkley 1997, Bootstrap methods and their application, chapters 2 and 5;
/// van der Leeden, Meijer and Busing 2008, Handbook of multilevel analysis, chapter 11.
Bootstrap bootstrap(const FittedModel& fit,
                    const data::Table& table,
                    const BootstrapOptions& options = {});

}  // namespace silvafit::fit
