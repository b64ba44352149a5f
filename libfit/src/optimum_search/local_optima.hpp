// SPDX-License-Identifier: MIT
// Ends of Lindstrom and Bates' method from many starts, and maxima of the first-order likelihood.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "lindstrom_bates/lindstrom_bates_search.hpp"
#include "marginal_likelihood/marginal_fit.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/search_evidence.hpp"
#include "optimum_search/smaller_structures.hpp"
#include "optimum_search/starting_points.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The work of a search in operations, counted by its steps so that the result does not depend on
/// the machine.
class SearchBudget {
 public:
  /// \param operations  of the search
  SearchBudget(const NonlinearModel& model, double operations) : left_(operations) {
    double q = 0.0;
    for (const RandomEffects& term : model.specification().random) {
      q += static_cast<double>(term.coefficients.size());
    }
    const auto n = static_cast<double>(model.observations());
    const auto p = static_cast<double>(model.coefficient_count());
    const auto groups = static_cast<double>(model.group_count());
    constexpr double kStep = 1e4;  // of any step: as much as the rows of a small data set
    pass_ = kStep + n * (p + q + 2.0);
    // The cross products of the linear models of all groups.
    alternation_ = kStep + groups * std::pow(p + q + 1.0, 3);
    // The modes, with about three sums of second derivatives.
    evaluation_ = kStep + n * 3.0 * (1.0 + q) * (1.0 + q);
  }

  void spend_work(const LindstromBatesWork& work) {
    left_ -= work.passes * pass_ + work.alternations * alternation_;
  }
  void spend_evaluations(int count) { left_ -= count * evaluation_; }
  bool is_spent() const { return left_ < 0.0; }

 private:
  double pass_ = 0.0;         ///< of Lindstrom and Bates' method over the data
  double alternation_ = 0.0;  ///< of its variance components
  double evaluation_ = 0.0;   ///< of a marginal likelihood
  double left_ = 0.0;
};

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
              const MixedEffectsOptions& options,
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
  void try_other_variances();
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
  void compare_with_none();
  void compare_with(const SmallerStructure& smaller);

  const NonlinearModel& model_;
  MixedEffectsOptions options_;
  std::vector<StartingPoint> starts_;
  SearchBudget budget_;
  std::vector<VectorXd> failed_;  ///< pooled minima from which no run reached a fixed point
  int climbs_ = 0;                ///< searches of a maximum
  std::vector<Candidate> ends_;
  std::vector<Candidate> maxima_;
  std::vector<ContainedModel> contained_;
};

}  // namespace silvafit::fit
