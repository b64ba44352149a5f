// SPDX-License-Identifier: MIT
// Maxima of the marginal likelihood of a method, searched from local optima.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "marginal_likelihood/marginal_fit.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/local_optima.hpp"
#include "optimum_search/search_evidence.hpp"

namespace silvafit::fit {

/// Searches from the best local optima, and from smaller structures.
class MarginalMaxima {
 public:
  /// \param pooled  (p) coefficients of the pooled fit
  MarginalMaxima(const NonlinearModel& model,
                 const VectorXd& pooled,
                 Method method,
                 const MixedEffectsOptions& options,
                 const LocalOptima& found);

  /// \param most  number of starts
  void search(std::size_t most);
  std::vector<Candidate>& all() { return maxima_; }
  /// The highest maximum, or a point far above it at which a search has not converged.
  const Candidate& best() const;
  SearchEvidence evidence(const Candidate& best) const;

 private:
  double value_at(const MixedEffectsFit& fit, Method method) const;
  std::vector<Candidate> starts() const;
  void add_laplace_maxima(std::vector<Candidate>& starts) const;
  void follow(const std::vector<Candidate>& all, std::size_t most);
  void try_from(const MixedEffectsFit& start, const std::string& origin);
  void add(MarginalEnd end, const std::string& origin);
  void compare_with_smaller();
  void compare_with(const SmallerStructure& smaller);
  void try_exchanged();
  void search_across_kinks();
  void search_longer();
  void finish_highest();
  void prefer_exact_fit();
  void rank_ends();
  const Candidate* unfinished_above(const MixedEffectsFit& fit, double difference) const;

  const NonlinearModel& model_;
  const VectorXd& pooled_;
  Method method_;
  bool is_first_order_;
  const MixedEffectsOptions& options_;
  const LocalOptima& found_;
  std::vector<Candidate> maxima_;
  std::vector<ContainedModel> contained_;
};

}  // namespace silvafit::fit
