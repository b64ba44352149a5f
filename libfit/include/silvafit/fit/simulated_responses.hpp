// SPDX-License-Identifier: MIT
// Responses that are drawn from a fit, on the design of a table.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// N rows of a table in its order, R replicates.
struct SimulatedResponses {
  std::vector<std::size_t> rows{};  ///< (N) those where all columns of the model have values
  Eigen::MatrixXd values{};         ///< (N x R)
};

/// Draws new random effects for each group and new residuals, as the parametric bootstrap does.
///
/// Each replicate has a random stream of its own: replicate r of a bootstrap with the same seed
/// refits to column r.
/// \throws UsageError without converged estimates; NumericalError if the mean is not finite with
///   the effects that were drawn; as NonlinearModel for the table
SimulatedResponses simulate_responses(const FittedModel& fit,
                                      const data::Table& table,
                                      std::size_t replicates,
                                      std::uint64_t seed = 1);

}  // namespace silvafit::fit
