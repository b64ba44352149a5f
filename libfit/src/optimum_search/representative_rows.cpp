// SPDX-License-Identifier: MIT
#include "optimum_search/representative_rows.hpp"

namespace silvafit::fit {

using Eigen::Index;

std::vector<Index> representative_rows(const NonlinearModel& model) {
  constexpr Index kRows = 2000;
  constexpr Index kFewestClusters = 30;
  const Index step = (model.observations() + kRows - 1) / kRows;
  std::vector<Index> rows;
  if (model.cluster_count() < step * kFewestClusters) {
    for (Index i = 0; i < model.observations(); i += step) rows.push_back(i);
    return rows;
  }
  for (Index c = 0; c < model.cluster_count(); c += step) {
    const Index end = model.group_begin(model.cluster_begin(c + 1));
    for (Index i = model.group_begin(model.cluster_begin(c)); i < end; ++i) rows.push_back(i);
  }
  return rows;
}

}  // namespace silvafit::fit
