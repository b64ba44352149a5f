// SPDX-License-Identifier: MIT
// Selection of the coefficients at bounds: branch and bound over fits with some of them held.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "fit_model/bound_slopes.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Coefficients and the values that they are held at.
using HeldValues = std::map<std::string, double>;

/// Fits with some coefficients held. From a fit nearby, unless null, only by ascent: to its own
/// maximum, or to a fit that has not converged. A fit that is impossible has not converged and has
/// values NaN.
using HeldFit = std::function<FitResult(const HeldValues& held, const FittedModel* nearby)>;

/// Slopes of the likelihood at a converged fit; see at_held.
using SlopesOf = std::function<HeldPoint(const FittedModel& fit, const HeldValues& held)>;

/// The best fit within the bounds that the search for a fit outside of them knows, or finds from a
/// known optimum or one with exchanged coefficients; none if it knows none. Null for no such
/// search.
/// \param found  the fit outside
/// \param held   the coefficients that it holds at bounds
using InsideFit =
    std::function<std::optional<FitResult>(const FittedModel& found, const HeldValues& held)>;

/// The search that fit_constrained describes. Used once.
class BoundedSearch {
 public:
  BoundedSearch(const std::map<std::string, Bounds>& bounds,
                const HeldFit& fit,
                const SlopesOf& slopes_of,
                const InsideFit& inside = {})
      : bounds_(bounds), fit_(fit), slopes_of_(slopes_of), inside_(inside) {}

  FitResult run();

 private:
  /// A fit with coefficients held at bounds, and its properties.
  struct Candidate {
    FitResult result;
    HeldValues held{};
    HeldPoint point{};                   ///< of a converged fit
    std::vector<std::string> crossed{};  ///< free coefficients outside their range
    std::vector<std::string> rising{};   ///< held ones from which the likelihood rises inwards

    bool converged() const { return result.fit.convergence.converged(); }
    bool is_inside() const { return crossed.empty(); }
    /// Fulfils the conditions of Karush, Kuhn and Tucker.
    bool is_optimal() const { return converged() && is_inside() && rising.empty(); }
  };
  /// A set of held coefficients that has not been fitted yet.
  struct Branch {
    HeldValues held{};
    double limit = kInfinity;  ///< upper limit of the log-likelihood of its fits
  };
  /// Results of the sets that were fitted.
  struct Outcome {
    bool converged = false;
    double value = 0.0;
    std::vector<std::string> rising{};
  };

  Candidate candidate(const HeldValues& held, FitResult result) const;
  Candidate candidate(const HeldValues& held, const FittedModel* nearby) const {
    return candidate(held, fit_(held, nearby));
  }
  bool rises_inwards(const std::string& name, double slope, double at) const;
  void branch_from(const Candidate& at, double limit);
  void open(const HeldValues& held, double limit);
  Branch take_most_promising();
  bool can_be_better(double limit) const;
  void keep(Candidate candidate);
  void search_between();
  bool rises_by_values(const Candidate& end, const std::string& name) const;
  bool release(const FittedModel& from, const HeldValues& held);
  bool has_maximum_between(const Candidate& end, const std::string& name) const;
  void halve(const Candidate& end, const std::string& name);
  void search_outwards();
  FitResult without_maximum(Candidate candidate) const;
  FitResult conclusion();
  // The reported results of a candidate, each with its convergence message.
  FitResult on_bounds(Candidate candidate) const;
  FitResult unfinished(Candidate candidate) const;
  FitResult rising_inwards(Candidate candidate) const;
  FitResult outside(Candidate candidate) const;
  std::vector<Evidence> at_bounds(const HeldValues& held) const;
  static double value_of(const Candidate& candidate);

  const std::map<std::string, Bounds>& bounds_;
  const HeldFit& fit_;
  const SlopesOf& slopes_of_;
  InsideFit inside_;
  std::vector<Branch> open_;
  std::set<HeldValues> known_;  ///< sets that were tried or are in the list of branches
  std::map<HeldValues, Outcome> outcomes_;
  bool limits_hold_ = true;        ///< no fit was better than one with fewer coefficients held
  std::optional<Candidate> best_;  ///< of those that fulfil the conditions
  std::vector<Candidate> ends_;    ///< feasible, but the likelihood rises from a bound inwards
  std::optional<Candidate> unfinished_;  ///< the best within the bounds that did not converge
  std::optional<Candidate> first_;       ///< the fit without bounds
  std::vector<std::string> unbounded_;   ///< coefficients towards whose infinity it is higher
};

}  // namespace silvafit::fit
