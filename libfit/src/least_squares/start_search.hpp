// SPDX-License-Identifier: MIT
// Start values of fits without start values from the user.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

struct StartSearchOptions {
  /// Coefficients that are not searched, by name.
  std::map<std::string, double> fixed{};
  /// One more candidate, by name; coefficients that it does not have are 1.
  std::map<std::string, double> rule{};
  /// Number of requested starts. Frequencies of a wave with a given phase that fit nearly as well
  /// as the best one are added.
  std::size_t count = 3;
  std::size_t divisor = 1;  ///< of the usual numbers of candidates, descents and hops
  int further_hops = 0;     ///< in addition to those of formulas with many coefficients
};

/// Good starts, best first, each near another minimum.
///
/// Candidates cover sign and logarithm of the nonlinear coefficients around the scales of the data
/// (a rate times a column is of order one) and, with lower density, far beyond; the linear
/// coefficients are solved for. Of frequencies and periods, all identifiable values are tried, and
/// no others. The best descend on at most 200 observations spread over the response.
/// \throws DomainError if an observation has no finite mean for any candidate
std::vector<VectorXd> search_starts(const NonlinearModel& model, const StartSearchOptions& options);

/// Coefficients of sub-models that are nearest to constants: an intercept takes the constant, and
/// covariates without an intercept are regressed on it.
/// \param pooled     the model without covariates
/// \param constants  (K) a value of each parameter
/// \returns (p) coefficients of the model
VectorXd spread_constants(const NonlinearModel& model,
                          const NonlinearModel& pooled,
                          const VectorXd& constants);

/// The start that gives a value for each coefficient; none if a coefficient is missing.
std::vector<VectorXd> complete_starts(const NonlinearModel& model,
                                      const std::map<std::string, double>& values);

/// Points around an optimum at which other optima are searched if the formula has kinks, because
/// each observation that changes from one branch to another may separate two. For each coefficient
/// with kinks they are up to three standard errors away, beyond which an optimum is not better, in
/// quarters of one.
/// \param errors  (p) standard errors; coefficients without one are left out
std::vector<Eigen::VectorXd> points_across_kinks(const NonlinearModel& model,
                                                 const Eigen::VectorXd& optimum,
                                                 const Eigen::VectorXd& errors);

/// At most this many observations, evenly spread over the ordered response, so that the order of
/// the rows in the file does not matter.
/// \param count  at least 2
/// \return numbers of the observations, ascending
std::vector<Index> even_sample(const VectorXd& response, Index count);

/// Searches an observation whose mean or derivative is not finite for any coefficients.
/// \throws DomainError that names the first one
void check_domain(const NonlinearModel& model);

}  // namespace silvafit::fit
