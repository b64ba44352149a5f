// SPDX-License-Identifier: MIT
#include "silvafit/stand/structure_classes.hpp"

#include <fmt/format.h>

#include <cmath>

#include "figures/joint_sums.hpp"
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

void JointSums::add(const StructuralUnits& units, std::span<const std::size_t> trees) {
  const std::vector<double>& rows = values_named(units, first_);
  const std::vector<double>& columns = values_named(units, second_);
  const std::size_t classes = units.neighbors + 1;
  sums_.neighbors = units.neighbors;
  sums_.share.resize(classes * classes);
  const auto class_of = [&units](double value) {
    return static_cast<std::size_t>(std::lround(value * static_cast<double>(units.neighbors)));
  };
  for (const std::size_t tree : trees) {
    if (units.core[tree] == 0 || rows.empty() || columns.empty()) continue;
    if (std::isnan(rows[tree]) || std::isnan(columns[tree])) continue;
    const double weight = units.weight_of(tree);
    ++sums_.trees;
    weight_ += weight;
    sums_.share[class_of(rows[tree]) * classes + class_of(columns[tree])] += weight;
  }
}

JointDistribution JointSums::distribution() const {
  JointDistribution result = sums_;
  for (double& share : result.share) share = weight_ > 0.0 ? share / weight_ : data::kMissing;
  return result;
}

}  // namespace silvafit::stand
