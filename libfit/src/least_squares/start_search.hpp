// SPDX-License-Identifier: MIT
// Where to start a fit that nobody gave start values for.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

struct StartSearchOptions {
  /// Coefficients that are not searched, by name.
  std::map<std::string, double> fixed{};
  /// One more candidate, by name; what it does not name is 1.
  std::map<std::string, double> rule{};
  std::size_t count = 3;  ///< of starts that are wanted
  int further_hops = 0;   ///< besides those that a formula with many coefficients gets
};

/// Good starts for a model without covariates, best first, each near another minimum.
///
/// Candidates cover sign and logarithm of the nonlinear coefficients around the scales of the data
/// (a rate times a column is of order one) and, thinner, far beyond; the linear coefficients are
/// solved for. Of frequencies and periods, all that the data tell apart are tried, and none beyond.
/// The best descend on at most 200 observations spread over the response.
/// \throws DomainError if an observation has no finite mean for any candidate
std::vector<Eigen::VectorXd> search_starts(const NonlinearModel& model,
                                           const StartSearchOptions& options);

/// Coefficients of sub-models that come nearest to constants: intercepts take them over, and
/// covariates without an intercept are regressed on them.
/// \param pooled     the model without covariates
/// \param constants  (K) a value of each parameter
/// \returns (p) coefficients of the model
Eigen::VectorXd spread_constants(const NonlinearModel& model,
                                 const NonlinearModel& pooled,
                                 const Eigen::VectorXd& constants);

/// The start that values by coefficient name give, if they name all coefficients; else none.
std::vector<Eigen::VectorXd> complete_starts(const NonlinearModel& model,
                                             const std::map<std::string, double>& values);

/// At most so many observations, evenly spread over the ordered response, so that the order of the
/// rows in the file does not matter.
/// \param count  at least 2
/// \return numbers of the observations, ascending
std::vector<Eigen::Index> even_sample(const Eigen::VectorXd& response, Eigen::Index count);

/// Looks for an observation whose mean or slope is not finite, whatever the coefficients.
/// \throws DomainError that names the first one
void check_domain(const NonlinearModel& model);

}  // namespace silvafit::fit
