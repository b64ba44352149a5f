// SPDX-License-Identifier: MIT
#include "result/earlier_fit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

data::Table trees_of(const std::string& species) {
  const data::Table all =
      data::read_csv_table(test::source_file("examples/fir-mixed/inventory.csv"));
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < all.rows(); ++row) {
    if (all.text("species")[row] == species) rows.push_back(row);
  }
  return all.select(rows);
}

data::Table without_plot(const data::Table& table, double plot) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.numbers("plot")[row] != plot) rows.push_back(row);
  }
  return table.select(rows);
}

ModelSpecification height_curve(const data::Table& table,
                                const std::string& random,
                                const std::string& variance) {
  ModelSpecification model = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, table);
  if (!random.empty()) add_random_effects(model, random, table);
  model.variance = parse_variance_function(variance);
  return model;
}

/// The result of a refit relative to the fit without it. They differ only for a likelihood with
/// several maxima.
enum class End { kSame, kHigher, kLower };

/// Checks that a refit converges where the fit from scratch does, and has its estimates if it ends
/// at the same maximum.
///
/// Both have converged to within 1e-6 standard errors. At a maximum that leaves the likelihood
/// exact to 1e-12; 1e-8 is asked for. That of lb and gnls belongs to a linear model which moves
/// with the coefficients, so that its error is of first order: 1e-8 of its size is asked for.
End end_of_refit(const ModelSpecification& model,
                 const data::Table& table,
                 const FittedModel& earlier,
                 FitModelOptions options) {
  const FittedModel scratch = fit_model(model, table, options).fit;
  options.from = &earlier;
  const FittedModel refit = fit_model(model, table, options).fit;
  INFO(word_of(scratch.method) << ", variance " << model.variance.text() << ", "
                               << scratch.convergence.verdict() << " / "
                               << refit.convergence.verdict());
  CHECK(refit.convergence.converged() == scratch.convergence.converged());
  if (!scratch.convergence.converged()) return End::kSame;
  const bool is_marginal = is_mixed(scratch.method) && scratch.method != Method::kLindstromBates;
  const double tolerance = is_marginal || scratch.method == Method::kOrdinary
                               ? 1e-8
                               : 1e-8 * std::abs(scratch.log_likelihood);
  if (refit.log_likelihood > scratch.log_likelihood + tolerance) return End::kHigher;
  if (refit.log_likelihood < scratch.log_likelihood - tolerance) return End::kLower;
  const Eigen::VectorXd errors = scratch.standard_errors();
  CHECK(((refit.estimate - scratch.estimate).cwiseQuotient(errors)).cwiseAbs().maxCoeff() < 1e-4);
  return End::kSame;
}

}  // namespace

TEST_CASE("a refit from an earlier fit reaches the optimum of a fit from scratch", "[slow]") {
  int refits = 0;
  int higher = 0;
  int lower = 0;
  for (const std::string species : {"SM", "BHN", "MH"}) {
    const data::Table table = trees_of(species);
    const data::Table fewer = without_plot(table, 4.0);
    for (const std::string variance : {"none", "power", "exponential", "constant-plus-power"}) {
      for (const std::string random : {"", "a | plot", "a + b | plot"}) {
        const ModelSpecification model = height_curve(table, random, variance);
        std::vector<Method> methods{Method::kLindstromBates,
                                    Method::kFirstOrder,
                                    Method::kInteraction,
                                    Method::kLaplace,
                                    Method::kQuadrature};
        if (random.empty()) methods = {default_method(model)};
        for (const Method method : methods) {
          const FitModelOptions options{.method = method, .quadrature_points = 3};
          const FittedModel whole = fit_model(model, table, options).fit;
          INFO(species << ", random effects '" << random << "'");
          refits += 2;
          for (const data::Table* const data : {&table, &fewer}) {
            const End end = end_of_refit(model, *data, whole, options);
            if (end == End::kHigher) ++higher;
            if (end == End::kLower) ++lower;
          }
        }
      }
    }
  }
  CHECK(refits == 264);
  // SM without plot 4, random effects a + b, constant plus power: two maxima on the edge cor(a, b)
  // = -1, between which the four marginal likelihoods' fits from scratch choose by their last
  // digits.
  CHECK(higher + lower <= 4);
}

TEST_CASE("a variance function starts from the fit with a constant variance") {
  const data::Table table = trees_of("SM");
  const FitModelOptions usual{.method = Method::kLindstromBates};
  const FittedModel constant = fit_model(height_curve(table, "a | plot", "none"), table, usual).fit;
  REQUIRE(constant.convergence.converged());
  for (const std::string variance : {"power", "exponential"}) {
    const ModelSpecification model = height_curve(table, "a | plot", variance);
    CHECK(as_start(constant, NonlinearModel(model, table)).has_value());
    FitModelOptions options = usual;
    options.from = &constant;
    const FittedModel found = fit_model(model, table, options).fit;
    const FittedModel scratch = fit_model(model, table, usual).fit;
    REQUIRE(found.convergence.converged());
    // Both end where an iteration changes theta by less than 1e-6 standard errors.
    CHECK(found.log_likelihood == Approx(scratch.log_likelihood).margin(1e-6));
    // In the other order the weights would be lost.
    const ModelSpecification simpler = height_curve(table, "a | plot", "none");
    CHECK_FALSE(as_start(found, NonlinearModel(simpler, table)).has_value());
  }
}
