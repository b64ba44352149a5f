// SPDX-License-Identifier: MIT
// The limit of the work of a search over starting points.
#pragma once

#include <cmath>

#include "lindstrom_bates/lindstrom_bates.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

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

}  // namespace silvafit::fit
