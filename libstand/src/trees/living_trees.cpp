// SPDX-License-Identifier: MIT
#include "trees/living_trees.hpp"

#include <cmath>
#include <utility>

namespace silvafit::stand {
namespace {

double between(double first, double second, double share) {
  return first + share * (second - first);
}

}  // namespace

std::size_t LivingTrees::add(std::size_t row, const std::string& label) {
  return add_between(row, row, 0.0, label);
}

std::size_t LivingTrees::add_between(std::size_t first,
                                     std::size_t second,
                                     double share,
                                     const std::string& label) {
  rows_.push_back(first);
  result_.plot.append(label);
  result_.tree.append(source_.tree[first]);
  source_.species.is_missing(first) ? result_.species.append_missing()
                                    : result_.species.append(source_.species[first]);
  const auto copy = [&](const std::vector<double>& from, std::vector<double>& to) {
    if (!from.empty()) to.push_back(between(from[first], from[second], share));
  };
  copy(source_.x, result_.x);
  copy(source_.y, result_.y);
  copy(source_.dbh_cm, result_.dbh_cm);
  copy(source_.h_m, result_.h_m);
  result_.quantities.resize(source_.quantities.size());
  for (std::size_t i = 0; i < source_.quantities.size(); ++i) {
    result_.quantities[i].name = source_.quantities[i].name;
    result_.quantities[i].unit = source_.quantities[i].unit;
    copy(source_.quantities[i].values, result_.quantities[i].values);
  }
  if (first < source_.lines.size()) result_.lines.push_back(source_.lines[first]);
  result_.neighbor_only.push_back(std::isnan(result_.dbh_cm.back()) ? 1 : 0);
  return rows_.size() - 1;
}

Inventory LivingTrees::finish() && {
  result_.file = source_.file;
  result_.expansion = source_.expansion;
  result_.trusts_units = source_.trusts_units;
  result_.other = source_.other.select(rows_);
  return std::move(result_);
}

}  // namespace silvafit::stand
