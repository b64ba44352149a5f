// SPDX-License-Identifier: MIT
#include "silvafit/fit/convergence.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "silvafit/base/random.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_specification.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// y = 2 + 3 x with noise, in five groups without any difference.
data::Table alike_groups() {
  Random random(3);
  data::Table table;
  data::TextColumn group;
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 100; ++i) {
    group.append("g" + std::to_string(i % 5));
    x.push_back(0.1 * i);
    y.push_back(2.0 + 3.0 * x.back() + random.normal());
  }
  table.set("group", group);
  table.set("x", x);
  table.set("z", x);
  table.set("y", y);
  return table;
}

FittedModel fitted(const std::string& formula, const std::string& random = {}) {
  const data::Table table = alike_groups();
  ModelSpecification model = specify_model(formula, {}, table);
  if (!random.empty()) add_random_effects(model, random, table);
  return fit_model(model, table).fit;
}

}  // namespace

TEST_CASE("the names of statuses and kinds of evidence are read back") {
  for (int i = 0; i <= static_cast<int>(ConvergenceStatus::kUnknown); ++i) {
    const auto status = static_cast<ConvergenceStatus>(i);
    CHECK_FALSE(word_of(status).empty());
    CHECK(find_word<ConvergenceStatus>(word_of(status)) == status);
  }
  for (int i = 0; i <= static_cast<int>(Evidence::Kind::kPowerOfFew); ++i) {
    const auto kind = static_cast<Evidence::Kind>(i);
    CHECK_FALSE(word_of(kind).empty());
    CHECK(find_word<Evidence::Kind>(word_of(kind)) == kind);
  }
  CHECK_FALSE(find_word<Evidence::Kind>("of a later version"));
}

TEST_CASE("a converged fit with a parameter at its bound is a boundary fit") {
  Convergence convergence{.status = ConvergenceStatus::kConverged};
  CHECK_FALSE(convergence.has_boundary());
  convergence.add_boundary({.term = "sd(b)", .value = 0.0});
  convergence.add_boundary({.kind = Evidence::Kind::kUpperBound, .term = "a", .value = 60.0});
  convergence.add(Evidence::Kind::kMoving, {"c"});
  CHECK(convergence.status == ConvergenceStatus::kBoundary);
  CHECK(convergence.converged());
  CHECK(convergence.boundary() == std::vector<std::string>{"sd(b) = 0", "a = 60, its upper bound"});
  Convergence failed{.status = ConvergenceStatus::kIterationLimit};
  failed.add_boundary({.term = "sd(b)", .value = 0.0});
  CHECK(failed.status == ConvergenceStatus::kIterationLimit);
}

TEST_CASE("a fit has its status, and the parameters of the status as evidence") {
  CHECK(fitted("y ~ a + b*x").convergence.status == ConvergenceStatus::kConverged);

  // There is no variance between groups: in most draws, as in this one, the ML estimate of their
  // standard deviation is 0.
  const FittedModel singular = fitted("y ~ a + b*x", "a | group");
  CHECK(singular.convergence.status == ConvergenceStatus::kBoundary);
  CHECK(singular.convergence.has(Evidence::Kind::kBoundary, "sd(a)"));

  const FittedModel collinear = fitted("y ~ a + b*x + c*z");
  CHECK(collinear.convergence.status == ConvergenceStatus::kNotIdentifiable);
  CHECK(collinear.convergence.has(Evidence::Kind::kNotIdentifiable, "b"));
  CHECK(collinear.convergence.has(Evidence::Kind::kNotIdentifiable, "c"));
  CHECK(collinear.convergence.summary() == "not identifiable: b, c");

  const FittedModel mixed = fitted("y ~ a + b*x + c*z", "a | group");
  CHECK(mixed.convergence.status == ConvergenceStatus::kNotIdentifiable);
  CHECK(mixed.convergence.has(Evidence::Kind::kNotIdentifiable, "b"));
}

TEST_CASE("status and evidence are stored with a fit") {
  const FittedModel fit = fitted("y ~ a + b*x", "a | group");
  const FittedModel read = from_json(json_of(fit).dump(), "fit.json");
  CHECK(read.convergence.status == fit.convergence.status);
  REQUIRE(read.convergence.evidence.size() == fit.convergence.evidence.size());
  CHECK(read.convergence.boundary() == fit.convergence.boundary());

  auto older = json_of(fit);
  older.erase("status");
  older["evidence"].erase("findings");
  older["evidence"]["boundary"] = {"b = 4.5, its lower bound", "sd(a) = 0"};
  const FittedModel earlier = from_json(older.dump(), "fit.json");
  CHECK(earlier.convergence.converged());
  CHECK(earlier.convergence.has(Evidence::Kind::kLowerBound, "b"));
  CHECK(earlier.convergence.boundary() ==
        std::vector<std::string>{"b = 4.5, its lower bound", "sd(a) = 0"});
}
