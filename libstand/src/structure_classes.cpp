// SPDX-License-Identifier: MIT
#include "silvafit/stand/structure_classes.hpp"

#include <fmt/format.h>

#include <cmath>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

const std::vector<double>& values_named(const StructuralUnits& units, std::string_view name) {
  if (name == "W") return units.W;
  if (name == "M") return units.M;
  if (name == "U") return units.U;
  if (name == "C") return units.C;
  throw UsageError(fmt::format("unknown index '{}'; available: W, M, U, C", name));
}

}  // namespace

JointDistribution joint_distribution(const StructuralUnits& units,
                                     std::string_view first,
                                     std::string_view second) {
  const std::vector<double>& rows = values_named(units, first);
  const std::vector<double>& columns = values_named(units, second);
  const std::size_t classes = units.neighbors + 1;
  JointDistribution result{.neighbors = units.neighbors,
                           .share = std::vector<double>(classes * classes, 0.0)};
  const auto class_of = [&units](double value) {
    return static_cast<std::size_t>(std::lround(value * static_cast<double>(units.neighbors)));
  };
  double sum = 0.0;
  for (std::size_t tree = 0; tree < units.core.size(); ++tree) {
    if (units.core[tree] == 0 || rows.empty() || columns.empty()) continue;
    if (std::isnan(rows[tree]) || std::isnan(columns[tree])) continue;
    const double weight = units.weight_of(tree);
    ++result.trees;
    sum += weight;
    result.share[class_of(rows[tree]) * classes + class_of(columns[tree])] += weight;
  }
  for (double& share : result.share) share = sum > 0.0 ? share / sum : data::kMissing;
  return result;
}

}  // namespace silvafit::stand
