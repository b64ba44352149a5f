// SPDX-License-Identifier: MIT
// The limit of the work of a search over starting points.
#pragma once

#include <cmath>

#include "lindstrom_bates/lindstrom_bates.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Approximate seconds of a search, counted by its steps so that the result does not depend on the
/// machine.
class SearchBudget {
 public:
  /// \param points   of quadrature a random effect
  /// \param seconds  of the search
  SearchBudget(const NonlinearModel& model, int points, double seconds) : left_(seconds) {
    const ModelSpecification& specification = model.specification();
    double effects = 0.0;
    for (const RandomEffects& term : specification.random) {
      effects += static_cast<double>(term.coefficients.size());
    }
    const auto p = static_cast<double>(model.coefficient_count());
    const auto n = static_cast<double>(model.observations());
    // Measured times.
    pass_ = 8e-9 * n * (p + effects + 2.0);
    alternation_ = 25e-9 * static_cast<double>(model.group_count()) * std::pow(p + effects + 1, 3);
    evaluation_ = n * (2.5e-8 * (1.0 + effects) * (1.0 + effects) +
                       (points > 1 ? 1e-8 * std::pow(points, effects) : 0.0));
  }

  void spend_work(const LindstromBatesWork& work) {
    left_ -= work.passes * pass_ + work.alternations * alternation_;
  }
  void spend_evaluations(int count) { left_ -= count * evaluation_; }
  bool is_spent() const { return left_ < 0.0; }

 private:
  double pass_ = 0.0;         ///< of Lindstrom and Bates' method over the data, in seconds
  double alternation_ = 0.0;  ///< of its variance components
  double evaluation_ = 0.0;   ///< of a marginal likelihood
  double left_ = 0.0;
};

}  // namespace silvafit::fit
