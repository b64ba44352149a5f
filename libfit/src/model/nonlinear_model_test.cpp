// SPDX-License-Identifier: MIT
#include "silvafit/fit/nonlinear_model.hpp"

#include <catch2/catch.hpp>

using namespace silvafit::fit;
using Catch::Matchers::Contains;
using Eigen::VectorXd;
using silvafit::data::Table;

namespace {

/// Five trees of two plots, one without height.
Table five_trees() {
  Table table(5);
  table.set("plot", std::vector<double>{7, 8, 7, 8, 7});
  table.set("dbh", std::vector<double>{10, 20, 30, 40, 50});
  table.set("C", std::vector<double>{0, 1, 2, 3, 4});
  table.set("h", std::vector<double>{11, silvafit::data::kMissing, 13, 14, 15});
  table.set_origin("trees.csv", {2, 3, 4, 6, 7});
  return table;
}

NonlinearModel by_plot(const Table& table) {
  ModelSpecification specification = specify_model("h ~ a + b*dbh", {"b ~ 1 + C"}, table);
  specification.random = parse_random_effects("a | plot");
  return {specification, table};
}

VectorXd mean_of(const NonlinearModel& model, const VectorXd& coefficients) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  model.evaluate(coefficients, mean, nullptr, workspace);
  return mean;
}

}  // namespace

TEST_CASE("too many random effects are refused") {
  const Table table = five_trees();
  ModelSpecification specification = specify_model("h ~ a + b*dbh", {"b ~ 1 + C"}, table);
  const auto with = [&](std::size_t of_last, std::size_t of_first) {
    specification.random = parse_random_effects("a | plot; a | dbh");
    specification.random.back().coefficients.assign(of_last, "a");
    specification.random.front().coefficients.assign(of_first, "a");
    if (of_first == 0) specification.random.erase(specification.random.begin());
    return specification;
  };
  CHECK_NOTHROW(NonlinearModel(with(6, 6), table));
  CHECK_THROWS_WITH(NonlinearModel(with(7, 6), table), Contains("13 random effects"));
  CHECK_THROWS_WITH(NonlinearModel(with(13, 0), table), Contains("at most 12"));
}

TEST_CASE("values whose squares overflow or vanish are refused with their column") {
  const auto scaled = [](const std::string& column, double factor) {
    Table table = five_trees();
    const auto numbers = table.numbers(column);
    std::vector<double> values(numbers.begin(), numbers.end());
    for (double& value : values) value *= factor;
    table.set(column, values);
    table.set_origin("trees.csv", {2, 3, 4, 6, 7});
    return table;
  };
  for (const std::string column : {"h", "dbh", "C"}) {
    CHECK_NOTHROW(by_plot(scaled(column, 1e130)));
    CHECK_NOTHROW(by_plot(scaled(column, 1e-130)));
    CHECK_THROWS_WITH(by_plot(scaled(column, 1e200)),
                      Contains("trees.csv") && Contains(column) && Contains("squares overflow") &&
                          Contains("use another unit"));
    CHECK_THROWS_WITH(by_plot(scaled(column, 1e-200)), Contains("squares are zero"));
  }
}

TEST_CASE("rows are complete and sorted by group, with their lines") {
  const NonlinearModel model = by_plot(five_trees());
  CHECK(model.rows() == std::vector<std::size_t>{0, 2, 4, 3});
  CHECK(model.excluded() == 1);
  CHECK(model.group_labels() == std::vector<std::string>{"7", "8"});
  CHECK(model.place(3).file == "trees.csv");
  CHECK(model.place(3).line == 6);
}

TEST_CASE("a subset is the model of those observations") {
  const NonlinearModel model = by_plot(five_trees());
  const VectorXd coefficients = Eigen::Vector3d(1.0, 0.5, -0.01);
  const VectorXd mean = mean_of(model, coefficients);

  const NonlinearModel part = model.subset({1, 3});
  CHECK(part.rows() == std::vector<std::size_t>{2, 3});
  CHECK(part.group_labels() == std::vector<std::string>{"7", "8"});
  CHECK(part.group_begin(1) == 1);
  CHECK(mean_of(part, coefficients) == VectorXd(Eigen::Vector2d(mean[1], mean[3])));
  CHECK(part.place(1).line == 6);

  const NonlinearModel last = model.subset({3});
  CHECK(last.group_labels() == std::vector<std::string>{"8"});
  CHECK(last.group_count() == 1);
}

TEST_CASE("the pooled model has a constant for each parameter") {
  const NonlinearModel model = by_plot(five_trees());
  const NonlinearModel pooled = model.pooled();
  CHECK(pooled.coefficient_names() == std::vector<std::string>{"a", "b"});
  // a + b dbh at dbh 10, 30, 50, 40
  CHECK(mean_of(pooled, Eigen::Vector2d(1.0, 0.5)) == VectorXd(Eigen::Vector4d(6, 16, 26, 21)));
  CHECK(pooled.is_bilinear(0, 1));
}

TEST_CASE("held parameters have their value in the mean") {
  const Table table = five_trees();
  const NonlinearModel model = by_plot(table).pooled();
  const NonlinearModel held = model.with_held({{"a", 1.5}});
  CHECK(held.coefficient_names() == std::vector<std::string>{"b"});
  const VectorXd all = Eigen::Vector2d(1.5, 0.25);
  CHECK(mean_of(held, all.tail(1)) == mean_of(model, all));
}

TEST_CASE("a coefficient has its parameter and its covariate") {
  const NonlinearModel model = by_plot(five_trees());
  CHECK(model.design().parameter_of(2) == 1);
  CHECK(model.design().multiplier(1) == nullptr);
  CHECK(Eigen::Map<const VectorXd>(model.design().multiplier(2), 4) ==
        VectorXd(Eigen::Vector4d(0, 2, 4, 3)));
}

TEST_CASE("a formula with a kink is not linear in its parameters") {
  struct Formula {
    const char* text = nullptr;
    bool is_linear = false;
  };
  const Table table = five_trees();
  for (const auto& [text, is_linear] : {
           Formula{"h ~ max(a*dbh, 3)", false},
           Formula{"h ~ max(a*dbh, -1e9)", false},
           Formula{"h ~ min(dbh, a + 1e6)", false},
           Formula{"h ~ abs(a*dbh + 1e6)", false},
           Formula{"h ~ ifelse(a > 1e6, 2, 1)*dbh + a", false},
           Formula{"h ~ a*dbh + (a < -1e6)", false},
           Formula{"h ~ ifelse(dbh > 25, a*dbh, a + 1)", true},
           Formula{"h ~ a*max(dbh, 30) + abs(C - 2)", true},
           Formula{"h ~ a*dbh^2", true},
           Formula{"h ~ exp(a*dbh)", false},
       }) {
    INFO(text);
    const NonlinearModel model(specify_model(text, {}, table), table);
    CHECK(model.is_bilinear(0, 0) == is_linear);
  }
}
