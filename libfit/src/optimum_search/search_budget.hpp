// SPDX-License-Identifier: MIT
// The limit of the work of a search over starting points.
#pragma once

#include <cmath>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Approximate seconds of a search, counted by its steps so that the result does not depend on the
/// machine.
class SearchBudget {
 public:
  /// \param points  of quadrature a random effect
  SearchBudget(const NonlinearModel& model, int points) {
    const ModelSpecification& specification = model.specification();
    double effects = 0.0;
    for (const RandomEffects& term : specification.random) {
      effects += static_cast<double>(term.coefficients.size());
    }
    const auto p = static_cast<double>(model.coefficient_count());
    const auto n = static_cast<double>(model.observations());
    // Measured times of a pass over the data, and of the variance components of an iteration.
    alternation_ = 6e-9 * n * (p + effects + 2.0) +
                   25e-9 * static_cast<double>(model.group_count()) * std::pow(p + effects + 1, 3);
    evaluation_ = n * (2.5e-8 * (1.0 + effects) * (1.0 + effects) +
                       (points > 1 ? 1e-8 * std::pow(points, effects) : 0.0));
  }

  void spend_alternations(int count) { spent_ += count * alternation_; }
  void spend_evaluations(int count) { spent_ += count * evaluation_; }
  bool is_spent() const {
    constexpr double kSeconds = 2.0;
    return spent_ > kSeconds;
  }

 private:
  double alternation_ = 0.0;  ///< of Lindstrom and Bates' method, in seconds
  double evaluation_ = 0.0;   ///< of a marginal likelihood
  double spent_ = 0.0;
};

}  // namespace silvafit::fit
