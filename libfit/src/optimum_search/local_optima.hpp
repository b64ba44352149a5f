// SPDX-License-Identifier: MIT
// Ends of Lindstrom and Bates' method from many starts, and maxima of the first-order likelihood.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lindstrom_bates/lindstrom_bates_search.hpp"
#include "marginal_likelihood/marginal_fit.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/search_budget.hpp"
#include "optimum_search/search_evidence.hpp"
#include "optimum_search/smaller_structures.hpp"
#include "optimum_search/starting_points.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The ends of local searches from a list of starting points, each once.
///
/// Lindstrom and Bates' method is the cheap local search: it runs from each start. Its ends are
/// ranked by the first-order marginal likelihood (FOCEI), which is bounded, smooth and valid
/// everywhere; their own likelihoods are those of different linear models. The maxima of this
/// likelihood near the best ends are starts again, as long as they lead to new ends.
class LocalOptima {
 public:
  /// \param starts  at least one
  LocalOptima(const NonlinearModel& model,
              const MixedEffectsOptions& linearized,
              const MarginalOptions& marginal,
              std::vector<StartingPoint> starts);

  /// \param is_result  whether the ends of Lindstrom and Bates' method are the result; else they
  ///   are starts, and further ones are searched only if there are several
  void search(bool is_result);
  void add(LocalOptima&& other);

  /// Ends of Lindstrom and Bates' method, converged or not.
  std::vector<Candidate>& ends() { return ends_; }
  const std::vector<Candidate>& ends() const { return ends_; }
  /// Maxima of the first-order likelihood.
  const std::vector<Candidate>& maxima() const { return maxima_; }
  const std::vector<ContainedModel>& contained() const { return contained_; }
  /// Whether more than one end is known, or none converged.
  bool has_several() const { return ends_.size() > 1 || !has_converged(ends_); }

 private:
  void descend();
  void search_longer();
  void climb();
  bool has_high_end() const;
  void climb_exactly();
  void explore();
  void compare_with_smaller();
  /// \return  the rank of the end; -infinity if no fixed point was reached
  double run_from(const StartingPoint& point, double spread = 1.0);
  std::optional<MixedEffectsFit> fixed_point_from(const NonlinearModel& model,
                                                  const MixedEffectsFit& start);
  /// \return  the same
  double add_end(MixedEffectsFit fit, const std::string& origin, Obstacle obstacle = {});
  bool is_complete() const;
  void climb_from_failed();
  void climb_from(const MixedEffectsFit& start);
  void add_maximum(MarginalEnd end);
  void start_from_own_minima();
  void compare_with_none();
  void compare_with(const SmallerStructure& smaller);

  const NonlinearModel& model_;
  MixedEffectsOptions linearized_;
  const MarginalOptions& marginal_;
  std::vector<StartingPoint> starts_;
  SearchBudget budget_;
  std::vector<Eigen::VectorXd> failed_;  ///< pooled minima from which no run reached a fixed point
  int climbs_ = 0;                       ///< searches of a maximum
  std::vector<Candidate> ends_;
  std::vector<Candidate> maxima_;
  std::vector<ContainedModel> contained_;
};

}  // namespace silvafit::fit
