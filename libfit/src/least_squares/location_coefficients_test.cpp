// SPDX-License-Identifier: MIT
#include "least_squares/location_coefficients.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/fit/least_squares.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// Names of the location coefficients of a formula of x, which is 1, 2, ..., 20.
std::vector<std::string> locations(const std::string& formula) {
  data::Table table;
  std::vector<double> x;
  for (int i = 1; i <= 20; ++i) x.push_back(i);
  table.set("x", x);
  table.set("y", x);
  const NonlinearModel model(specify_model(formula, {}, table), table);
  std::vector<std::string> names;
  for (const LocationCoefficient& found : location_coefficients(model)) {
    names.push_back(model.coefficient_names()[static_cast<std::size_t>(found.coefficient)]);
  }
  return names;
}

}  // namespace

TEST_CASE("coefficients that are shifted with a column are locations") {
  CHECK(locations("y ~ a/(1 + exp((b - x)/c))") == std::vector<std::string>{"b"});
  CHECK(locations("y ~ a/(1 + exp((b - x)/c)) + d/(1 + exp((m - x)/c))") ==
        std::vector<std::string>{"b", "m"});
  CHECK(locations("y ~ h - 2*(h - g)/(exp(s*(x - t)) + exp(r*(x - t)))") ==
        std::vector<std::string>{"t"});
}

TEST_CASE("coefficients that are shifted with the logarithm of a column are locations") {
  // x^g/(exp(g*l) + x^g) depends on log(x) - l.
  CHECK(locations("y ~ a*x^g/(exp(g*l) + x^g)") == std::vector<std::string>{"l"});
  // exp(l)*x depends on log(x) + l.
  CHECK(locations("y ~ a*exp(-exp(l)*x)") == std::vector<std::string>{"l"});
}

TEST_CASE("other coefficients are no locations") {
  CHECK(locations("y ~ a*(1 - exp(-b*x))^c").empty());
  CHECK(locations("y ~ a*x/(b + x)").empty());
  CHECK(locations("y ~ a*exp(-b*exp(-c*x))").empty());
}

TEST_CASE("the range of a location is that of the observations") {
  data::Table table;
  table.set("x", std::vector<double>{2.0, 3.0, 5.0, 8.0});
  table.set("y", std::vector<double>{1.0, 2.0, 3.0, 4.0});
  const NonlinearModel model(specify_model("y ~ a*exp(-exp(l)*x)", {}, table), table);
  const std::vector<LocationCoefficient> found = location_coefficients(model);
  REQUIRE(found.size() == 1);
  CHECK(found[0].lowest == Approx(-std::log(8.0)).epsilon(1e-15));
  CHECK(found[0].highest == Approx(-std::log(2.0)).epsilon(1e-15));
}

TEST_CASE("curves of two phases are found without start values") {
  // A sum of two logistic curves, and growth of Preece and Baines (1978, Annals of Human Biology
  // 5, 1-24), with residuals far below the curves' sizes: no other minimum is near the true one.
  const std::vector<std::pair<std::string, std::vector<double>>> curves{
      {"y ~ a/(1 + exp((b - x)/c)) + d/(1 + exp((m - x)/k))", {8.0, 5.0, 0.9, 12.0, 14.0, 1.6}},
      {"y ~ lo + (hi - lo)*(f/(1 + exp((b - x)/s)) + (1 - f)/(1 + exp((m - x)/s)))",
       {0.5, 10.0, 0.4, 5.0, 15.0, 0.8}},
      {"y ~ h - 2*(h - g)/(exp(s*(x - t)) + exp(r*(x - t)))", {174.0, 162.0, 0.11, 14.0, 1.2}}};
  for (const auto& [formula, truth] : curves) {
    INFO(formula);
    data::Table table;
    std::vector<double> x;
    for (int i = 2; i < 40; ++i) x.push_back(0.5 * i);
    table.set("x", x);
    table.set("y", x);
    const NonlinearModel shape(specify_model(formula, {}, table), table);
    NonlinearModel::Workspace workspace;
    Eigen::VectorXd mean;
    // Coefficients are in the order of the formula's text, as the truth is.
    shape.evaluate(Eigen::Map<const Eigen::VectorXd>(truth.data(), std::ssize(truth)),
                   mean,
                   nullptr,
                   workspace);
    std::vector<double> y(mean.begin(), mean.end());
    for (std::size_t i = 0; i < y.size(); ++i)
      y[i] += 0.01 * std::cos(7.0 * static_cast<double>(i));
    table.set("y", y);
    const LeastSquaresFit fit =
        fit_least_squares(NonlinearModel(specify_model(formula, {}, table), table));
    // Residuals of the truth are 0.01 cos: their mean square is 0.5e-4.
    CHECK(fit.sum_of_squares < 0.6e-4 * static_cast<double>(y.size()));
  }
}

TEST_CASE("a column far from 0 is named if its shift is another value of the coefficients") {
  data::Table table;
  std::vector<double> year;
  std::vector<double> since;
  for (int i = 0; i < 26; ++i) {
    year.push_back(1985.0 + i);
    since.push_back(i);
  }
  table.set("yr", year);
  table.set("t", since);
  table.set("y", since);
  const auto names = [&](const std::string& formula) {
    std::string result;
    const NonlinearModel model(specify_model(formula, {}, table), table);
    for (const FarColumn& column : far_columns(model)) {
      CHECK(column.middle == 1997.5);
      result += column.name;
    }
    return result;
  };
  CHECK(names("y ~ A*exp(-b*exp(-k*yr))") == "yr");
  CHECK(names("y ~ A/(1 + b*exp(-k*yr))") == "yr");
  CHECK(names("y ~ c + A*exp(-k*t)").empty());
  CHECK(names("y ~ V*yr/(K + yr)").empty());  // another curve if yr is shifted
}
