// SPDX-License-Identifier: MIT
#include "likelihood/linearization.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "test_support/nested_trees.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace silvafit::fit;
using silvafit::data::Table;

namespace {

/// Plots of given sizes, the first two in one stand, the others in another.
Table plots_of(const std::vector<int>& sizes) {
  silvafit::Random random(3);
  std::vector<NestedTree> trees;
  for (std::size_t j = 0; j < sizes.size(); ++j) {
    for (int i = 0; i < sizes[j]; ++i) {
      NestedTree tree{.stand = j < 2 ? "A" : "B", .plot = std::to_string(j)};
      tree.species = random.uniform(0.0, 1.0) < 0.5 ? "fir" : "oak";
      tree.dbh_cm = random.uniform(5.0, 45.0);
      tree.crowding = random.uniform(0.0, 1.0);
      tree.h_m = 25.0 * (1.0 - std::exp(-0.07 * tree.dbh_cm)) + random.normal(0.0, 1.5);
      trees.push_back(tree);
    }
  }
  return table_of(trees);
}

/// Five plots, one of them with more trees than a block.
Table five_plots() { return plots_of({7, 1, 600, 30, 12}); }

NonlinearModel model_with(const std::string& variance, const Table& table, unsigned threads = 1) {
  ModelSpecification specification =
      specify_model("h ~ a*(1 - exp(-b*dbh)) + c", {"b ~ 1 + C"}, table);
  add_random_effects(specification, "a | stand; a + b:C | plot", table);
  specification.variance = parse_variance_function(variance);
  return {specification, table, threads};
}

/// a, b, b:C, c.
LinearizationPoint point_of(const NonlinearModel& model, const VectorXd& variance) {
  LinearizationPoint point{.coefficients = Eigen::Vector4d(24.0, 0.07, 0.01, 0.5),
                           .effects = MatrixXd::Zero(4, 5),
                           .variance = variance,
                           .units = Eigen::Vector4d(2.0, 0.01, 0.03, 1.0)};
  for (Index group = 0; group < model.group_count(); ++group) {
    point.effects(0, group) = 0.5 * static_cast<double>(group) - 1.0;
    point.effects(2, group) = 0.002 * static_cast<double>(group);
  }
  return point;
}

constexpr const char* kVariances[] = {"none",
                                      "power",
                                      "constant-plus-power",
                                      "exponential(dbh | species)",
                                      "stratum(species) * power",
                                      "power(delta = 0.5)"};

}  // namespace

TEST_CASE("cross products are those of the Jacobian and the working response") {
  // The larger plots have more rows than a task of a thread.
  const std::vector<int> large{7, 1, 13000, 4100, 12};
  const bool is_large = GENERATE(false, true);
  const Table table = is_large ? plots_of(large) : five_plots();
  for (const char* const text : kVariances) {
    INFO(text);
    const NonlinearModel model = model_with(text, table, 3);
    const VarianceModel variance(model.specification().variance, VarianceData::of(model));
    const LinearizationPoint point = point_of(model, variance.start());
    Linearization at;
    REQUIRE(Linearizer(model, variance).linearize(point, true, nullptr, at));

    NonlinearModel::Workspace workspace;
    VectorXd mean;
    MatrixXd jacobian;
    const MatrixXd coefficients = point.effects.colwise() + point.coefficients;
    model.evaluate(coefficients, mean, &jacobian, workspace);
    const ResidualScale scale = variance.scale(mean, point.variance, false);
    CHECK((at.mean - mean).norm() == 0.0);
    CHECK(at.model.moments.sum_log()[0] == Approx(scale.sum_log).epsilon(1e-12).margin(1e-12));
    const MatrixXd x = jacobian * point.units.asDiagonal();
    const VectorXd residual = model.response() - mean;
    for (Index group = 0; group < 5; ++group) {
      const Index begin = model.group_begin(group);
      const Index rows = model.group_begin(group + 1) - begin;
      MatrixXd all(rows, 5);
      all << x.middleRows(begin, rows),
          residual.segment(begin, rows) +
              jacobian.middleRows(begin, rows) * point.effects.col(group);
      const MatrixXd expected =
          all.transpose() * scale.weight.segment(begin, rows).matrix().asDiagonal() * all;
      const Eigen::Map<const MatrixXd> products(at.model.moments.term(group, 0), 5, 5);
      // Sums of up to 13,000 rows.
      CHECK((products - expected).norm() < 1e-12 * expected.norm());
      const double squares =
          (scale.weight.segment(begin, rows) * residual.segment(begin, rows).array().square())
              .sum();
      CHECK(at.squares[group] == Approx(squares).epsilon(1e-12));
    }
  }
}

TEST_CASE("a linearization does not depend on the number of threads") {
  const Table table = plots_of({7, 1, 13000, 4100, 12});
  for (const char* const text : kVariances) {
    INFO(text);
    const auto linearized = [&](unsigned threads) {
      const NonlinearModel model = model_with(text, table, threads);
      const VarianceModel variance(model.specification().variance, VarianceData::of(model));
      Linearizer linearizer(model, variance);
      const LinearizationPoint point = point_of(model, variance.start());
      Linearization before;
      Linearization at;
      REQUIRE(linearizer.linearize(point, true, nullptr, before));
      REQUIRE(linearizer.linearize(point, true, &before, at));
      return at;
    };
    const Linearization one = linearized(1);
    const Linearization three = linearized(3);
    const GroupMoments& moments = one.model.moments;
    CHECK(moments.sum_log() == three.model.moments.sum_log());
    CHECK(one.squares_before == three.squares_before);
    CHECK(one.longest_change == three.longest_change);
    using Products = Eigen::Map<const VectorXd>;
    for (Index group = 0; group < moments.groups(); ++group) {
      const Index size = 25 * moments.terms();
      CHECK(Products(moments.term(group, 0), size) ==
            Products(three.model.moments.term(group, 0), size));
    }
    // With the same weights the squares are equal except for the order of sums.
    CHECK((one.squares - one.squares_before).norm() < 1e-12 * one.squares.norm());
  }
}

TEST_CASE("the terms of the series are derivatives by the variance parameters") {
  const Table table = five_plots();
  for (const char* const text : kVariances) {
    INFO(text);
    const NonlinearModel model = model_with(text, table);
    const VarianceModel variance(model.specification().variance, VarianceData::of(model));
    Linearizer linearizer(model, variance);
    const auto moments_at = [&](const VectorXd& parameters) {
      Linearization at;
      REQUIRE(linearizer.linearize(point_of(model, parameters), true, nullptr, at));
      return at.model.moments;
    };
    const VectorXd start = variance.start();
    const GroupMoments here = moments_at(start);
    REQUIRE(here.parameters() == start.size());
    // Central differences with step 1e-5 are accurate to ten digits of the larger elements.
    constexpr double kStep = 1e-5;
    for (Index k = 0; k < start.size(); ++k) {
      const VectorXd step = kStep * VectorXd::Unit(start.size(), k);
      const GroupMoments above = moments_at(start + step);
      const GroupMoments below = moments_at(start - step);
      const auto compare = [&](Index term, Index of) {
        for (Index group = 0; group < 5; ++group) {
          using Products = Eigen::Map<const VectorXd>;
          const VectorXd difference =
              (Products(above.term(group, of), 25) - Products(below.term(group, of), 25)) /
              (2.0 * kStep);
          const Products exact(here.term(group, term), 25);
          CHECK((exact - difference).norm() <= 1e-8 * (1.0 + exact.norm()));
        }
        CHECK(here.sum_log()[term] ==
              Approx((above.sum_log()[of] - below.sum_log()[of]) / (2.0 * kStep))
                  .epsilon(1e-8)
                  .margin(1e-7));
      };
      compare(1 + k, 0);
      for (std::size_t pair = 0; pair < here.pairs().size(); ++pair) {
        const auto [first, second] = here.pairs()[pair];
        if (second == k) compare(1 + here.parameters() + static_cast<Index>(pair), 1 + first);
      }
    }
  }
}

TEST_CASE("a point where the mean is not finite is reported") {
  const Table table = five_plots();
  const NonlinearModel model = model_with("power", table);
  const VarianceModel variance(model.specification().variance, VarianceData::of(model));
  LinearizationPoint point = point_of(model, variance.start());
  point.coefficients[1] = -1e5;
  Linearization at;
  CHECK_FALSE(Linearizer(model, variance).linearize(point, true, nullptr, at));
}
