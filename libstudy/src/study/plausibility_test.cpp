// SPDX-License-Identifier: MIT
// Implausible curves are reported with their place; plausible ones are not.
#include "study/plausibility.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "study/study_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

constexpr int kTrees = 5;

/// Two plots of five trees, with DBH 10 to 50 cm: curves are judged up to 60 cm.
data::Table plausible_trees() {
  data::TextColumn plots;
  std::vector<double> dbh;
  std::vector<double> h;
  std::vector<double> hcb;
  std::vector<double> cw;
  std::vector<double> crowding;
  for (const char* plot : {"1", "2"}) {
    for (int k = 1; k <= kTrees; ++k) {
      plots.append(plot);
      dbh.push_back(10.0 * k);
      h.push_back(1.3 + std::pow(dbh.back() / (2.0 + 0.2 * dbh.back()), 2));
      hcb.push_back(0.5 * h.back());
      cw.push_back(1.0 + 0.1 * dbh.back());
      crowding.push_back(*plot == '1' ? 0.25 : 0.75);
    }
  }
  data::Table table;
  table.set("plot", std::move(plots));
  table.set("dbh", std::move(dbh));
  table.set("h", std::move(h));
  table.set("hcb", std::move(hcb));
  table.set("cw", std::move(cw));
  table.set("C", std::move(crowding));
  return table;
}

/// A fit with given coefficients.
fit::FittedModel model(const std::string& formula,
                       const std::vector<double>& coefficients,
                       const std::vector<std::string>& sub_models = {}) {
  fit::FittedModel fit(fit::specify_model(formula, sub_models, plausible_trees()));
  fit.coefficient_names = fit.specification.coefficient_names();
  fit.estimate = Eigen::Map<const Eigen::VectorXd>(coefficients.data(),
                                                   static_cast<Eigen::Index>(coefficients.size()));
  const Eigen::Index p = fit.estimate.size();
  fit.covariance = Eigen::MatrixXd::Identity(p, p);
  fit.sigma = 1.0;
  fit.convergence.status = fit::ConvergenceStatus::kConverged;
  return fit;
}

/// The same with a random effect on one coefficient, known for the two plots.
fit::FittedModel with_effects(fit::FittedModel fit,
                              const std::string& name,
                              double first,
                              double second) {
  fit.specification.random = {{.coefficients = {name}, .group = "plot"}};
  fit.random.resize(1);
  fit.method = fit::Method::kLindstromBates;
  fit.random.back().names = {name};
  fit.random.back().labels = {"1", "2"};
  fit.random.back().covariance = Eigen::MatrixXd::Identity(1, 1);
  fit.random.back().effects.resize(1, 2);
  fit.random.back().effects << first, second;
  return fit;
}

std::string objection(const fit::FittedModel& fit, const char* entry = nullptr) {
  const data::Table table = plausible_trees();
  const Plausibility plausibility(fit.specification.formula.left, table, "plot");
  return plausibility.objection(fit, entry == nullptr ? nullptr : &test::catalogue().find(entry));
}

}  // namespace

TEST_CASE("plausible curves have no objection") {
  CHECK(objection(model("h ~ 1.3 + dbh^2/(a*dbh + b)^2", {0.2, 2.0}), "M1").empty());
  // A curve that is flat for large trees.
  CHECK(objection(model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {18.0, 0.5}), "M4").empty());
  // Undefined at DBH 0, where its limit is 1.3 m.
  CHECK(objection(model("h ~ 1.3 + a*exp(-b/dbh)", {22.0, 12.0}), "M3").empty());
  // A formula of the user, whose value at a DBH of a millimeter rounds to zero.
  CHECK(objection(model("h ~ a*exp(-b/dbh)", {22.0, 100.0})).empty());
  CHECK(objection(model("hcb ~ h/(1 + exp(a + b*dbh))", {0.3, 0.01}), "M17").empty());
  CHECK(objection(model("cw ~ a + b*dbh", {1.0, 0.1}), "M22").empty());
}

TEST_CASE("a decreasing height is reported with its highest and last point") {
  // 1.3 + dbh - dbh^2/80 has its maximum at 40 cm: 21.3 m; at 60 cm it is 16.3 m.
  const std::string text = objection(model("h ~ 1.3 + a*dbh + b*dbh^2", {1.0, -1.0 / 80.0}));
  CHECK_THAT(text, Contains("The curve of the population falls from 21.30 m at a DBH of"));
  CHECK_THAT(text, Contains("to 16.30 m at 60.0 cm"));
  // Crown widths may decrease, and other responses are not checked.
  CHECK(objection(model("cw ~ a*dbh^b*exp(-c*dbh)", {1.0, 0.6, 0.02})).empty());
}

TEST_CASE("poles and negative values between the trees are found") {
  // A pole at 30.1 cm, between two trees.
  CHECK_FALSE(objection(model("h ~ 1.3 + a*dbh/(b - dbh)", {5.0, 30.1})).empty());
  CHECK_THAT(objection(model("cw ~ a + b*dbh", {-2.0, 0.14})),
             Contains("is -1.99 m at a DBH of 0.1 cm"));
  CHECK_THAT(objection(model("h ~ a*log(dbh - b)", {5.0, 5.0})), Contains("is not finite"));
}

TEST_CASE("extrapolated values are compared with the largest measured value") {
  // The tallest tree has 1.3 + (50/12)^2 = 18.66 m; twice that is passed where exp(0.1 dbh) does.
  CHECK_THAT(objection(model("h ~ a*exp(b*dbh)", {0.2, 0.1})),
             Contains("the largest value measured is 18.66 m"));
}

TEST_CASE("crown bases must be below the tops") {
  CHECK_THAT(objection(model("hcb ~ h*a*dbh", {0.02})),
             Contains("lies above the height at a DBH of"));
  CHECK_THAT(objection(model("hcb ~ h/(a + exp(-b*dbh))", {0.9, 0.1}), "M20"),
             Contains("the crown base of large trees lies above their tops"));
}

TEST_CASE("implausible parameters of the catalogue are reported although the curve is plausible") {
  // With a = -40 and b = -0.001 the curve rises to 4.7 m at 60 cm and has its pole at 1000^(1/1).
  const std::string text =
      objection(model("h ~ 1.3 + a/(1 + 1/(b*dbh^c))", {-40.0, -0.001, 1.0}), "M16");
  CHECK(text ==
        "For the population, the upper limit of the height lies below breast height (a = -40, b = "
        "-0.001, c = 1).");
  CHECK(objection(model("h ~ 1.3 + a/(1 + 1/(b*dbh^c))", {-40.0, -0.001, 1.0})).empty());
}

TEST_CASE("a limit far above the measured values is an objection") {
  // Nearly a line: 0.3 m a centimeter, towards 30,000 m.
  CHECK_THAT(objection(model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {30000.0, 1e-5}), "M4"),
             Contains("the asymptote, 3e+04 m, is far above"));
}

TEST_CASE("the curve of every plot is examined with its own random effect") {
  const fit::FittedModel typical = model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {18.0, 0.05});
  CHECK(objection(with_effects(typical, "b", 0.01, -0.01), "M4").empty());
  CHECK(objection(with_effects(typical, "b", 0.01, -0.06), "M4") ==
        "For plot 2, the height has no upper limit (a = 18, b = -0.01).");
  // Without the catalogue, the curve itself: 1.3 + 18 (1 - exp(0.01 * 60)) = -13.50.
  CHECK_THAT(
      objection(with_effects(typical, "b", 0.01, -0.06)),
      Contains("The curve of plot 2 falls from 1.29 m") && Contains("to -13.50 m at 60.0 cm"));
}

TEST_CASE("the curve of every plot is examined with its own covariates") {
  // b = 0.05 + 0.1 (0.4 - C): positive at the median of all, 0.5, and 0 and less from 0.9 on.
  const fit::FittedModel fit =
      model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {18.0, 0.14, -0.2}, {"b ~ 1 + C"});
  // The plots have C = 0.25 and 0.75: b = 0.09 and -0.01.
  CHECK_THAT(objection(fit, "M4"), Contains("For plot 2, the height has no upper limit"));
}

TEST_CASE("several curves with a flaw are counted") {
  const fit::FittedModel typical = model("h ~ 1.3 + a*dbh^b", {3.0, 0.4});
  CHECK_THAT(objection(with_effects(typical, "a", -6.0, -7.0)),
             Contains("plot 1") && Contains("2 of 3 curves have such a fault."));
}

TEST_CASE("other responses must only be finite") {
  data::Table table = plausible_trees();
  table.set("growth", std::vector<double>(2 * kTrees, -1.0));
  fit::FittedModel fit(fit::specify_model("growth ~ a + b*dbh", {}, table));
  fit.coefficient_names = {"a", "b"};
  fit.estimate = Eigen::Vector2d(1.0, -1.0);
  fit.covariance = Eigen::Matrix2d::Identity();
  fit.sigma = 1.0;
  const Plausibility plausibility("growth", table, "plot");
  CHECK(plausibility.objection(fit, nullptr).empty());
  fit.estimate[1] = std::nan("");
  CHECK_THAT(plausibility.objection(fit, nullptr), Contains("is not finite"));
}
