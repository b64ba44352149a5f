// SPDX-License-Identifier: MIT
#include "silvafit/tree/branch_count.hpp"

#include <cmath>
#include <utility>

#include "catalogue/preset_head.hpp"

namespace silvafit::tree {
namespace {

data::Expression equation_of_age(const data::JsonReader& entry) {
  data::Expression equation = entry.expression();
  for (const std::string& name : equation.variables()) {
    if (name != "age") entry.fail("may use only 'age', not '" + name + "'");
  }
  return equation;
}

}  // namespace

BranchCount::BranchCount(data::Expression total, data::Expression dead)
    : total_(std::move(total)), dead_(std::move(dead)) {}

BranchCount BranchCount::load(const std::filesystem::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-branch-count/1");
  BranchCount count(equation_of_age(entry.at("total")), equation_of_age(entry.at("dead")));
  count.name_ = entry.at("name").text();
  const data::JsonReader range = entry.at("age_range_years");
  count.youngest_years_ = range.at("from").number_between(0.0, 1000.0);
  count.oldest_years_ = range.at("to").number_between(count.youngest_years_, 1000.0);
  constexpr int kChecks = 100;
  for (int i = 0; i <= kChecks; ++i) {
    const double share = static_cast<double>(i) / kChecks;
    const Count at = *count.at(std::lerp(count.youngest_years_, count.oldest_years_, share));
    if (!(at.total > at.dead && at.dead > 0.0)) {
      entry.at("age_range_years").fail("total > dead > 0 must hold in the whole range of years");
    }
  }
  return count;
}

std::optional<BranchCount::Count> BranchCount::at(double age_years) const {
  if (!(age_years >= youngest_years_ && age_years <= oldest_years_)) return std::nullopt;
  return Count{.total = total_.value({"age"}, {age_years}),
               .dead = dead_.value({"age"}, {age_years})};
}

}  // namespace silvafit::tree
