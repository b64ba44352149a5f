// SPDX-License-Identifier: MIT
#include "trees/inventory_checks.hpp"

#include <fmt/format.h>

#include <cmath>

namespace silvafit::stand {
namespace {

// Larger than the coordinates of any map; the cells of the neighbor search are numbered up to it.
constexpr double kFarthestMeters = 1e9;

bool is_known(double value) { return !std::isnan(value); }

class RowChecker {
 public:
  explicit RowChecker(const Measures& row) : row_(row) {}

  void check_finite();
  void check_position();
  void check_required(bool needs_coordinates);
  void check_ranges(bool is_cw_from_radii);
  std::vector<Problem> take() { return std::move(problems_); }

 private:
  void add(std::size_t measure, std::string reason) {
    problems_.push_back({measure, std::move(reason)});
  }

  const Measures& row_;
  std::vector<Problem> problems_{};
};

void RowChecker::check_finite() {
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    if (std::isinf(row_[i])) add(i, "the value is not finite");
  }
}

void RowChecker::check_position() {
  for (const Measure measure : {kX, kY, kZ}) {
    const double value = row_[measure];
    if (std::isfinite(value) && std::abs(value) > kFarthestMeters) {
      add(measure,
          fmt::format("{} m is further than {} m from the origin", value, kFarthestMeters));
    }
  }
}

void RowChecker::check_required(bool needs_coordinates) {
  // A tree of known position is a neighbor of others.
  const bool is_placed = is_known(row_[kX]) && is_known(row_[kY]);
  if (!is_known(row_[kDbh]) && !is_placed) {
    add(kDbh, "is missing, and a tree without dbh and position cannot be used");
  }
  if (!needs_coordinates) return;
  if (!is_known(row_[kX])) add(kX, "is missing, so the tree has no position");
  if (!is_known(row_[kY])) add(kY, "is missing, so the tree has no position");
}

void RowChecker::check_ranges(bool is_cw_from_radii) {
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const TreeColumn& column = known_measure(i);
    if (!is_known(row_[i]) || column.is_possible(row_[i])) continue;
    if (i == kCw && is_cw_from_radii) {
      add(kCrE, fmt::format("the four crown radii make a width of {} m", row_[i]));
    } else {
      add(i, fmt::format("{} {} is not {}", row_[i], column.unit, column.range.text));
    }
  }
  const double hcb = row_[kHcb];
  if (hcb >= row_[kH]) add(kHcb, fmt::format("{} m is not below h {} m", hcb, row_[kH]));
}

}  // namespace

double crown_width_m(const Measures& row) {
  return ((row[kCrE] + row[kCrW]) + (row[kCrS] + row[kCrN])) / 2.0;
}

std::vector<Problem> problems_of(const Measures& row,
                                 bool needs_coordinates,
                                 bool is_cw_from_radii) {
  RowChecker checker(row);
  checker.check_finite();
  checker.check_position();
  checker.check_required(needs_coordinates);
  checker.check_ranges(is_cw_from_radii);
  return checker.take();
}

}  // namespace silvafit::stand
