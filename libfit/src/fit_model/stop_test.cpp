// SPDX-License-Identifier: MIT
#include "silvafit/base/stop.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <thread>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/bootstrap.hpp"
#include "silvafit/fit/cross_validation.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/intervals.hpp"
#include "test_support/known_fit.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// Heights by a curve whose asymptote varies between plots.
data::Table plots_of_trees(std::size_t plots, std::size_t trees) {
  Random random(5);
  std::vector<double> dbh;
  std::vector<double> h;
  std::vector<std::string> plot;
  for (std::size_t i = 0; i < plots * trees; ++i) {
    plot.push_back(std::to_string(i / trees));
    dbh.push_back(5.0 + 40.0 * random.uniform());
    const double asymptote = 25.0 + std::sin(static_cast<double>(i / trees)) * 3.0;
    h.push_back(1.3 + asymptote * (1.0 - std::exp(-0.06 * dbh.back())) + random.normal());
  }
  data::Table table;
  table.set("dbh", dbh);
  table.set("h", h);
  table.set("plot", texts(plot));
  return table;
}

ModelSpecification height_model(const data::Table& table, bool is_mixed) {
  ModelSpecification result = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, table);
  if (is_mixed) add_random_effects(result, "a | plot", table);
  return result;
}

}  // namespace

TEST_CASE("a fit ends where the caller asks for it") {
  const data::Table table = plots_of_trees(10, 20);
  const ModelSpecification specification = height_model(table, true);
  for (const Method method : {Method::kLindstromBates, Method::kInteraction, Method::kQuadrature}) {
    CAPTURE(word_of(method));
    std::stop_source source;
    int lines = 0;
    const FitModelOptions options{.method = method,
                                  .trace =
                                      [&](const std::string&) {
                                        if (++lines == 2) source.request_stop();
                                      },
                                  .stop = source.get_token()};
    CHECK_THROWS_AS(fit_model(specification, table, options), Stopped);
    CHECK(lines == 2);
  }
}

TEST_CASE("another thread stops least squares") {
  const data::Table table = plots_of_trees(100, 100);
  const ModelSpecification specification = height_model(table, false);
  std::stop_source source;
  const std::jthread other([&source] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    source.request_stop();
  });
  const auto fit_for_ever = [&] {
    while (true) (void)fit_model(specification, table, {.stop = source.get_token()});
  };
  CHECK_THROWS_AS(fit_for_ever(), Stopped);
}

TEST_CASE("refits and profiles end where the caller asks for it") {
  const data::Table table = plots_of_trees(10, 20);
  const FittedModel fit = fit_model(height_model(table, true), table).fit;
  REQUIRE(fit.convergence.converged());
  std::stop_source source;
  const auto stop_at_third = [&source](std::size_t done, std::size_t /*total*/) {
    if (done == 3) source.request_stop();
  };
  const FitModelOptions refit{.stop = source.get_token()};
  CHECK_THROWS_AS(bootstrap(fit, table, {.refit = refit, .progress = stop_at_third}), Stopped);
  source = std::stop_source();
  CHECK_THROWS_AS(
      cross_validate(
          fit, table, {.refit = {.stop = source.get_token()}, .progress = stop_at_third}),
      Stopped);
  CHECK_THROWS_AS(confidence_intervals(
                      fit, table, {.method = IntervalMethod::kProfile, .stop = source.get_token()}),
                  Stopped);
}
