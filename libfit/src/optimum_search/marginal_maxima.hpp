// SPDX-License-Identifier: MIT
// Maxima of a marginal likelihood, searched from fixed points of Lindstrom and Bates' method.
#pragma once

#include <string>
#include <vector>

#include "marginal_likelihood/marginal_fit.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/fixed_points.hpp"
#include "optimum_search/optimum_search.hpp"
#include "optimum_search/search_budget.hpp"
#include "optimum_search/search_verdict.hpp"

namespace silvafit::fit {

/// Searches from the best fixed points, from the maxima of cheaper likelihoods, and from smaller
/// structures.
class MarginalMaxima {
 public:
  /// \param integration  of the likelihood; `options` has that of the fit
  MarginalMaxima(const NonlinearModel& model,
                 const LeastSquaresFit& pooled,
                 const OptimumSearchOptions& options,
                 Integration integration,
                 FixedPoints& points);

  void search();
  /// Adds the findings of a finished search from other fixed points.
  void absorb(MarginalMaxima&& other);
  const std::vector<Candidate>& all() const { return maxima_; }
  /// The highest maximum, or a point far above it at which a search has not converged.
  const Candidate& best() const;
  SearchEvidence evidence(const Candidate& best) const;

 private:
  bool is_first_order() const;
  bool is_quadrature() const;
  MarginalOptions coarse_options() const;
  double value_at(const MixedEffectsFit& fit, Integration integration) const;
  std::vector<Candidate> starts();
  void add_first_order_maximum(std::vector<Candidate>& starts);
  void add_laplace_maxima(std::vector<Candidate>& starts);
  void follow(const std::vector<Candidate>& starts);
  void search_longer();
  void compare_with_smaller();
  void try_exchanged();
  void finish_highest();
  void prefer_exact_fit();
  void rank_ends();
  const Candidate* unfinished_above(const MixedEffectsFit& fit, double difference) const;
  void add(Candidate candidate);
  MarginalEnd search_from(const NonlinearModel& model,
                          const MixedEffectsFit& start,
                          Integration integration,
                          const MarginalOptions& options,
                          const MarginalEffort& effort = {});
  void try_from(const MixedEffectsFit& start, const std::string& origin);

  const NonlinearModel& model_;
  const LeastSquaresFit& pooled_;
  const OptimumSearchOptions& options_;
  Integration integration_;
  FixedPoints& points_;
  SearchBudget budget_;
  std::vector<Candidate> maxima_;
  std::vector<ContainedModel> contained_;
  bool has_searched_longer_ = false;                         ///< whether the longer search was done
  bool is_preliminary_ = false;                              ///< whether its maxima are only starts
  double known_ = -std::numeric_limits<double>::infinity();  ///< the highest value at a start
  bool has_laplace_maximum_ = false;                         ///< at which quadrature can start
  /// Of the first-order likelihood, if Laplace's is not valid at all fixed points.
  double first_order_maximum_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace silvafit::fit
