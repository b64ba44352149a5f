// SPDX-License-Identifier: MIT
#include "units/density_indices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "silvafit/base/error.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

constexpr char kOpenGrownOption[] = "`open_grown`";

data::Expression parsed(std::string_view text, const data::Table& table) {
  if (text.empty()) {
    throw UsageError(
        "CCF needs `open_grown`, the crown width of open-grown trees in m, such as \"0.9 + "
        "0.22*dbh\", from a source for your species",
        {.column = kOpenGrownOption});
  }
  data::Expression expression = data::Expression::parse(text);
  for (const std::string& name : data::columns_of(expression)) {
    if (table.has(name)) continue;
    throw InputError(data::no_such_column(name, table.names()),
                     {.file = table.file(), .column = kOpenGrownOption});
  }
  return expression;
}

}  // namespace

double basal_area_m2(double dbh_cm) {
  const double radius_m = dbh_cm / 200.0;
  return std::numbers::pi * radius_m * radius_m;
}

std::vector<double> basal_area_of_larger(const Inventory& inventory,
                                         const std::vector<SampledArea>& areas) {
  std::vector<double> result(inventory.size(), data::kMissing);
  for (const SampledArea& area : areas) {
    std::vector<std::size_t> trees = area.trees;
    const double hectares = area.area_m2 / kSquareMetersPerHectare;
    std::ranges::sort(trees, [&inventory](std::size_t left, std::size_t right) {
      return inventory.dbh_cm[left] > inventory.dbh_cm[right];
    });
    double larger_m2 = 0.0;
    for (std::size_t first = 0; first < trees.size();) {
      std::size_t next = first;
      double equal_m2 = 0.0;
      for (; next < trees.size() && inventory.dbh_cm[trees[next]] == inventory.dbh_cm[trees[first]];
           ++next) {
        result[trees[next]] = larger_m2 / hectares;
        equal_m2 +=
            inventory.trees_represented(trees[next]) * basal_area_m2(inventory.dbh_cm[trees[next]]);
      }
      larger_m2 += equal_m2;
      first = next;
    }
  }
  return result;
}

std::vector<double> crown_competition(const Inventory& inventory,
                                      const std::vector<SampledArea>& areas,
                                      std::string_view open_grown_crown) {
  const data::Table table = to_table(inventory);
  const std::vector<double> widths_m = data::evaluate(parsed(open_grown_crown, table), table);
  std::vector<double> result(inventory.size(), data::kMissing);
  for (const SampledArea& area : areas) {
    std::vector<double> crowns_m2;
    for (const std::size_t tree : area.trees) {
      if (!(widths_m[tree] >= 0.0) || std::isinf(widths_m[tree])) {
        throw UsageError(fmt::format("the crown width of an open-grown tree is {} m for dbh {} cm; "
                                     "it must be a positive number",
                                     widths_m[tree],
                                     inventory.dbh_cm[tree]),
                         {.column = kOpenGrownOption});
      }
      crowns_m2.push_back(inventory.trees_represented(tree) * std::numbers::pi / 4.0 *
                          widths_m[tree] * widths_m[tree]);
    }
    // Summed in order of size: the order of the rows then does not change the last digits.
    std::ranges::sort(crowns_m2);
    const double sum_m2 = std::accumulate(crowns_m2.begin(), crowns_m2.end(), 0.0);
    for (const std::size_t tree : area.trees) result[tree] = 100.0 * sum_m2 / area.area_m2;
  }
  return result;
}

}  // namespace silvafit::stand
