// SPDX-License-Identifier: MIT
#include "silvafit/tree/branch_count.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {
BranchCount chinese_fir() {
  return BranchCount::load(test::source_file("models/branch_count/chinese-fir.json"));
}
}  // namespace

// -106 + 276.3 - 38.33 and 105.53 - 92.039 + 35.012, by hand.
TEST_CASE("a Chinese fir of ten years has the published number of branches") {
  const BranchCount::Count count = chinese_fir().at(10.0).value();
  CHECK(count.total == Approx(131.97).epsilon(1e-12));
  CHECK(count.dead == Approx(48.503).epsilon(1e-12));
}

TEST_CASE("the equation gives no number outside its years") {
  const BranchCount equations = chinese_fir();
  CHECK(equations.at(equations.oldest_years()).value().live() > 0.0);
  CHECK_FALSE(equations.at(40.0));
  CHECK_FALSE(equations.at(1.0));
}

TEST_CASE("a range of years without living branches is refused") {
  const auto file = std::filesystem::temp_directory_path() / "silvafit-branch-count-test.json";
  write_file(file, R"({"schema": "silvafit-branch-count/1", "name": "t", "source": "s",
    "total": "-1.06*age^2 + 27.63*age - 38.33", "dead": "1.0553*age^2 - 9.2039*age + 35.012",
    "age_range_years": {"from": 3, "to": 16}})");
  CHECK_THROWS_AS(BranchCount::load(file), InputError);
  std::filesystem::remove(file);
}

TEST_CASE("age changes the number of branches up to the end of the equation") {
  const Preset& preset = test::shipped_presets().named("cunninghamia-lanceolata");
  const auto branches_at = [&](std::optional<double> age, std::size_t& notes) {
    Morphology tree = test::paper_tree_1();
    tree.age_years = age;
    const test::Stages stages = test::stages_of(tree, preset);
    notes = stages.skeleton.notes.size();
    std::size_t count = 0;
    for (const Axis& axis : stages.skeleton.axes) count += axis.order == 1 ? 1 : 0;
    return count;
  };
  std::size_t notes = 0;
  // 83.467 living branches; the four that reach the measured radii are among them.
  CHECK(branches_at(10.0, notes) == 83);
  CHECK(notes == 0);
  // A crown of 14.4 m has 26 whorls of four by its spacing, and at most 84 branches beside the
  // four.
  CHECK(branches_at(std::nullopt, notes) == 88);
  for (const double age : {15.0, 25.0, 60.0}) {
    CHECK(branches_at(age, notes) == 88);
    CHECK(notes == 1);
  }
}
