// SPDX-License-Identifier: MIT
#include "silvafit/fit/simulated_responses.hpp"

#include <algorithm>
#include <numeric>

#include "resampling/resampled_data.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

SimulatedResponses simulate_responses(const FittedModel& fit,
                                      const data::Table& table,
                                      std::size_t replicates,
                                      std::uint64_t seed) {
  if (!fit.convergence.converged()) {
    throw UsageError("responses cannot be drawn from a fit that has not converged");
  }
  // The draws are in the model's order: group by group.
  SimulatedResponses result{.rows = NonlinearModel(fit.specification, table).rows()};
  std::vector<Index> order(result.rows.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, {}, [&](Index i) { return result.rows[static_cast<std::size_t>(i)]; });
  std::ranges::sort(result.rows);

  const ParametricDraw parametric(fit, table);
  const auto count = static_cast<Index>(replicates);
  result.values.resize(static_cast<Index>(order.size()), count);
  for (Index r = 0; r < count; ++r) {
    Random random(seed, static_cast<std::uint64_t>(r) + 1);
    const Resampled drawn = parametric.draw(random);
    const auto values = drawn.table.numbers(fit.specification.formula.left);
    for (std::size_t i = 0; i < order.size(); ++i) {
      result.values(static_cast<Index>(i), r) = values[static_cast<std::size_t>(order[i])];
    }
  }
  return result;
}

}  // namespace silvafit::fit
