// SPDX-License-Identifier: MIT
// Responses drawn from a fit, with the design of a table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// N rows of a table in its order, R replicates.
struct SimulatedResponses {
  std::vector<std::size_t> rows{};  ///< (N) the complete rows
  Eigen::MatrixXd values{};         ///< (N x R)
};

/// Draws new random effects for each group and new residuals, as the parametric bootstrap does.
///
/// Each replicate has its own random stream: replicate r of a bootstrap with the same seed is
/// fitted to column r.
/// \throws UsageError without converged estimates; NumericalError if the mean is not finite with
///   the drawn effects; as NonlinearModel for the table
SimulatedResponses simulate_responses(const FittedModel& fit,
                                      const data::Table& table,
                                      std::size_t replicates,
                                      std::uint64_t seed = 1);

}  // namespace silvafit::fit
