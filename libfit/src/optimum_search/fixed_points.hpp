// SPDX-License-Identifier: MIT
// The fixed points of Lindstrom and Bates' method from several starting points.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "lindstrom_bates/lindstrom_bates_search.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/optimum_search.hpp"
#include "optimum_search/search_budget.hpp"
#include "optimum_search/search_verdict.hpp"
#include "optimum_search/smaller_structures.hpp"
#include "optimum_search/starting_points.hpp"

namespace silvafit::fit {

/// Where runs begin: at the user's start values, or at those that the program finds.
enum class Starts { kGiven, kFound };

/// Runs of Lindstrom and Bates' method, converged or not, each end point once. They are ranked by
/// their marginal likelihood, because their own is that of a different linear model at each.
class FixedPoints {
 public:
  /// \param from_part  (p) the best coefficients of a part of the observations; empty without one
  FixedPoints(const NonlinearModel& model,
              const LeastSquaresFit& pooled,
              const OptimumSearchOptions& options,
              const Eigen::VectorXd& from_part,
              Starts starts);

  /// Runs from all starting points.
  void search();
  /// Ranks the fits by the marginal likelihood and starts again: around the best ones, from maxima
  /// of the marginal likelihood, and from fits of smaller structures.
  void compare();
  /// The same without maxima of the marginal likelihood, for callers that search these themselves.
  void compare_briefly();
  /// Adds the findings of a search from other starts, after both have compared their fits.
  void absorb(FixedPoints&& other);

  std::vector<Candidate>& all() { return candidates_; }
  /// Maxima of the marginal likelihood that compare() has found from them.
  const std::vector<Candidate>& maxima() const { return maxima_; }
  /// Whether starts ended at different points, or none converged; otherwise more starts are
  /// useless.
  bool has_several_ends() const { return candidates_.size() > 1; }
  /// The likelihood that ranks fits: Laplace's if it is valid for all of them, else the first-order
  /// one, which always is.
  Integration ranking() const { return ranking_; }
  /// None if the comparison on a part of the observations was sufficient.
  std::vector<SmallerStructure> structures_to_compare() const;
  /// The model without random effects, by generalized least squares: a maximum of its likelihood
  /// may be one of the mixed model, at the boundary.
  void add_without_random_effects(std::vector<ContainedModel>& contained) const;
  /// The findings of the search for the convergence message of the best fixed point.
  SearchEvidence evidence(const Candidate& best) const;

 private:
  /// \return  whether a fixed point was reached
  bool linearize_from(const StartingPoint& point, Persistence persistence, double spread = 1.0);
  void start_with_effects_of(const StartingPoint& point);
  std::vector<StartingPoint> points() const;
  void rank();
  bool is_settled() const;
  bool has_similar_fixed_points() const;
  /// From the first starting point, with all starts of the variance components.
  void search_longer();
  void explore();
  void find_own_maximum();
  void follow_to_maxima();
  void follow_to_maximum(const MixedEffectsFit& start);
  void start_from_failed();
  /// Notes a maximum of a marginal likelihood; a new one is a start.
  void add_maximum(const MixedEffectsFit& maximum, Integration integration);
  void start_from_maxima();
  void start_from_own_minima();
  std::optional<MixedEffectsFit> fixed_point_from(const NonlinearModel& model,
                                                  const MixedEffectsFit& start);
  std::optional<MixedEffectsFit> maximum_from(const MixedEffectsFit& start,
                                              Integration integration);
  void compare_with_smaller();
  void go_on_from_smaller(const SmallerStructure& smaller, const MixedEffectsFit& found);
  std::vector<MixedEffectsFit> smaller_fits(const SmallerStructure& smaller,
                                            const MixedEffectsFit& whole);
  const Eigen::VectorXd& first_coefficients() const;

  const NonlinearModel& model_;
  const LeastSquaresFit& pooled_;
  const OptimumSearchOptions& options_;
  MixedEffectsOptions linearized_;  ///< of runs: without the user's starts
  const Eigen::VectorXd& from_part_;
  Starts starts_;
  SearchBudget budget_;
  StartingPoint first_;
  std::vector<Eigen::VectorXd>
      failed_;  ///< pooled minima from which no run has reached a fixed point
  std::vector<Candidate> candidates_;
  std::vector<Candidate> maxima_;  ///< of the marginal likelihood, used as starts
  std::vector<ContainedModel> contained_;
  Integration ranking_ = Integration::kLaplace;
  /// The highest maxima so far: of Laplace's likelihood, of the first-order one.
  double highest_laplace_ = -std::numeric_limits<double>::infinity();
  double highest_first_order_ = -std::numeric_limits<double>::infinity();
};

/// Whether the fit of a smaller structure is above that of a larger one.
bool is_higher(const MixedEffectsFit& smaller, const MixedEffectsFit& whole);

}  // namespace silvafit::fit
