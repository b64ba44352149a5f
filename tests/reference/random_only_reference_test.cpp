// SPDX-License-Identifier: MIT
// Random effects without a fixed effect against lme() and nlme() of R 4.2.2 with nlme 3.1-162;
// tests/reference/expected/README.md says how the figures were made.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "expected.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"
#include "silvafit/fit/prediction.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

// nlme's optimum of variances is at about 1e-6 of their logarithms, that of nlme() at 1e-5.
constexpr double kShare = 1e-4;

void check_fixed(const fit::FittedModel& fit, const json& reference) {
  std::size_t next = 0;
  for (Eigen::Index j = 0; j < fit.estimate.size(); ++j) {
    const std::string& name = fit.coefficient_names[static_cast<std::size_t>(j)];
    INFO(name);
    const json& held = reference["held"];
    if (std::find(held.begin(), held.end(), name) != held.end()) {
      CHECK(fit.estimate[j] == 0.0);
      CHECK(std::isnan(fit.standard_errors()[j]));
      CHECK(std::isnan(fit.degrees_of_freedom[j]));
      continue;
    }
    REQUIRE(next < reference["fixed"].size());
    const double error = reference["std_errors"][next];
    CHECK(fit.estimate[j] == Approx(reference["fixed"][next].get<double>()).margin(kShare * error));
    CHECK(fit.standard_errors()[j] == Approx(error).epsilon(kShare));
    CHECK(fit.degrees_of_freedom[j] == reference["df"][next].get<double>());
    ++next;
  }
  CHECK(next == reference["fixed"].size());
}

void check_covariances(const fit::FittedModel& fit, const json& reference) {
  REQUIRE(fit.random.size() == reference["covariances"].size());
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    const Eigen::MatrixXd& ours = fit.random[t].covariance;
    for (Eigen::Index i = 0; i < ours.rows(); ++i) {
      for (Eigen::Index j = 0; j < ours.cols(); ++j) {
        const double scale = std::sqrt(ours(i, i) * ours(j, j));
        const double expected = reference["covariances"][t][i][j];
        CHECK(ours(i, j) == Approx(expected).margin(kShare * scale));
      }
    }
  }
}

/// The groups of the fit as new ones have the effects of the fit.
void check_new_groups(const fit::FittedModel& fit, const data::Table& table) {
  const fit::Calibration found = fit::calibrate(fit, table, {.seen_groups = fit::SeenGroups::kNew});
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    REQUIRE(found.random[t].labels == fit.random[t].labels);
    const Eigen::VectorXd sd = fit.random[t].sd();
    const Eigen::MatrixXd difference = found.random[t].effects - fit.random[t].effects;
    // Both are modes to 1e-6 of their standard errors.
    CHECK((sd.cwiseInverse().asDiagonal() * difference).cwiseAbs().maxCoeff() < 1e-5);
  }
}

}  // namespace

TEST_CASE("random effects without a fixed effect are those of nlme", "[reference]") {
  const json file = test::read_expected("random_only.json");
  for (const json& reference : file["fits"]) {
    INFO(reference["id"]);
    const data::Table table = data::read_csv_table(test::reference_data(reference["data"]));
    fit::ModelTexts texts{.formula = reference["formula"],
                          .sub_models = reference["parameters"],
                          .random = reference["random"]};
    if (reference["diagonal"]) texts.covariance = {"diagonal"};
    fit::FitModelOptions options;
    options.method = fit::Method::kLindstromBates;
    options.reml = reference["reml"];
    for (const json& name : reference["held"]) options.fixed[name] = 0.0;
    const fit::FitResult result = fit::fit_model(specify_model(texts, table), table, options);
    const fit::FittedModel& fit = result.fit;
    CHECK(fit.convergence.converged());
    CHECK(fit.log_likelihood == Approx(reference["logLik"].get<double>()).margin(1e-6));
    CHECK(fit.aic() == Approx(reference["aic"].get<double>()).margin(2e-6));
    CHECK(fit.sigma == Approx(reference["sigma"].get<double>()).epsilon(kShare));
    check_fixed(fit, reference);
    check_covariances(fit, reference);
    for (std::size_t i = 0; i < result.rows.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double population = reference["population"][result.rows[i]];
      const double fitted = reference["fitted"][result.rows[i]];
      CHECK(result.fitted_population[k] == Approx(population).margin(kShare * fit.sigma));
      CHECK(result.fitted_conditional[k] == Approx(fitted).margin(kShare * fit.sigma));
    }
    check_new_groups(fit, table);
  }
}

TEST_CASE("marginal methods have the likelihood of a linear model with effects of mean zero",
          "[reference]") {
  // Without nonlinearity all methods have the same likelihood.
  const json file = test::read_expected("random_only.json");
  const std::string id = GENERATE("orthodont_slope_ml", "sleep_slope_ml", "oats_nested_ml");
  const fit::Method method =
      GENERATE(fit::Method::kInteraction, fit::Method::kLaplace, fit::Method::kFirstOrder);
  for (const json& reference : file["fits"]) {
    if (reference["id"] != id) continue;
    INFO(id << " by " << silvafit::word_of(method));
    const data::Table table = data::read_csv_table(test::reference_data(reference["data"]));
    const fit::ModelTexts texts{.formula = reference["formula"], .random = reference["random"]};
    fit::FitModelOptions options;
    options.method = method;
    options.fixed["u"] = 0.0;
    const fit::FittedModel fit = fit::fit_model(specify_model(texts, table), table, options).fit;
    CHECK(fit.convergence.converged());
    CHECK(fit.log_likelihood == Approx(reference["logLik"].get<double>()).margin(1e-6));
    CHECK(fit.estimate[0] == Approx(reference["fixed"][0].get<double>()).epsilon(1e-6));
  }
}

TEST_CASE("effects of mean zero have the uncertainty of a regression through the origin",
          "[reference]") {
  const data::Table table = data::read_csv_table(test::reference_data("Orthodont.csv"));
  const fit::ModelTexts texts{.formula = "distance ~ a + u*age", .random = "u | Subject"};
  fit::FitModelOptions options;
  options.fixed["u"] = 0.0;
  const fit::FittedModel fit = fit::fit_model(specify_model(texts, table), table, options).fit;
  REQUIRE(fit.convergence.converged());
  // Each child was measured at 8, 10, 12 and 14 years, so that x'x = 504 and x'1 = 44.
  const double psi = fit.random[0].covariance(0, 0);
  const double variance = fit.sigma * fit.sigma;
  const double shrunk = psi / (variance + 504.0 * psi);
  const fit::EffectUncertainty& of = fit.random[0].uncertainty;
  CHECK(of.covariances.minCoeff() == Approx(variance * shrunk).epsilon(1e-9));
  CHECK(of.covariances.maxCoeff() == Approx(variance * shrunk).epsilon(1e-9));
  // By a, and by u, which is known to be zero.
  REQUIRE(of.sensitivities.rows() == 2);
  CHECK(of.sensitivities.row(0).minCoeff() == Approx(-44.0 * shrunk).epsilon(1e-9));
  CHECK(of.sensitivities.row(1).minCoeff() == Approx(-504.0 * shrunk).epsilon(1e-9));
  // A new child of 9 years: the mean of the population, with the
  // variances of the effect, of the residual and of a.
  data::Table child;
  data::TextColumn subject;
  subject.append("new");
  child.set("age", std::vector{9.0});
  child.set("Subject", subject);
  const fit::Prediction at = fit::predict(fit, child, fit::Level::kPopulation, {.interval = 0.95});
  CHECK(at.value[0] == Approx(fit.estimate[0]));
  CHECK(at.mean_error[0] == Approx(fit.standard_errors()[0]).epsilon(1e-9));
  CHECK(at.prediction_error[0] ==
        Approx(std::sqrt(81.0 * psi + variance + fit.covariance(0, 0))).epsilon(1e-6));
}

TEST_CASE("a model may have random effects only", "[reference]") {
  // lmer(distance ~ 0 + (0 + age | Subject), Orthodont, REML = FALSE) of lme4 1.1-31.
  const data::Table table = data::read_csv_table(test::reference_data("Orthodont.csv"));
  const fit::ModelTexts texts{.formula = "distance ~ u*age", .random = "u | Subject"};
  fit::FitModelOptions options;
  options.method = GENERATE(fit::Method::kLindstromBates,
                            fit::Method::kFirstOrder,
                            fit::Method::kInteraction,
                            fit::Method::kLaplace,
                            fit::Method::kQuadrature);
  options.fixed["u"] = 0.0;
  const fit::FittedModel fit = fit::fit_model(specify_model(texts, table), table, options).fit;
  CHECK(fit.convergence.converged());
  CHECK(fit.parameter_count == 2);
  CHECK(fit.log_likelihood == Approx(-372.047479172).margin(1e-8));
  CHECK(fit.random[0].sd()[0] == Approx(2.1246).margin(5e-5));
  CHECK(fit.sigma == Approx(4.1031).margin(5e-5));
}

TEST_CASE("effects of mean zero do not depend on the origin of a covariate", "[reference]") {
  const std::string days = GENERATE("Days + 100", "Days + 1000");
  const data::Table table = data::read_csv_table(test::reference_data("sleepstudy.csv"));
  const fit::ModelTexts texts{.formula = "Reaction ~ a + u*(" + days + ")",
                              .random = "a + u | Subject"};
  fit::FitModelOptions options;
  options.method = GENERATE(fit::Method::kLindstromBates, fit::Method::kLaplace);
  options.fixed["u"] = 0.0;
  const fit::FittedModel fit = fit::fit_model(specify_model(texts, table), table, options).fit;
  INFO(fit.convergence.verdict());
  CHECK(fit.convergence.converged());
  // lme's for Days itself; lmer ends below it at -887.88 and -916.00.
  CHECK(fit.log_likelihood == Approx(-887.737940980548).margin(1e-6));
}
