// SPDX-License-Identifier: MIT
// Marginal likelihoods against their definitions, computed in R with dense matrices and fine grids;
// tests/reference/expected/README.md says how.
#include <Eigen/Cholesky>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "likelihood/marginal_likelihood.hpp"
#include "reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
// Terms are listed from the coarsest to the finest one.
using json = nlohmann::ordered_json;
using namespace silvafit;
using namespace silvafit::fit;

namespace {

json expected(const std::string& name) {
  std::ifstream stream(test::source_file("tests/reference/expected/" + name + ".json"));
  return json::parse(stream);
}

ModelSpecification specified(const json& reference, const data::Table& table) {
  ModelSpecification model = specify_model(reference["formula"].get<std::string>(), {}, table);
  std::string text;
  for (const auto& [group, random] : reference["random"].items()) {
    std::string effects;
    for (const json& name : random["effects"]) {
      effects += (effects.empty() ? "" : " + ") + name.get<std::string>();
    }
    if (!text.empty()) text += "; ";
    text += effects;
    text += " | ";
    text += group;
  }
  add_random_effects(model, text, table);
  model.variance = parse_variance_function(reference["variance"].get<std::string>());
  if (reference.contains("correlation")) {
    model.correlation = parse_correlation(reference["correlation"].get<std::string>());
  }
  return model;
}

/// The variance function and the correlation with the parameters of the reference, by nlme's
/// definitions.
VarianceEstimate estimate_of(const json& reference, const VarianceModel& variance) {
  VarianceEstimate estimate =
      VarianceEstimate::missing(parse_variance_function(reference["variance"].get<std::string>()));
  const json& values = reference["variance_parameters"];
  for (VarianceFactorEstimate& factor : estimate.factors) {
    factor.delta[0] = values.back().get<double>();
    if (factor.constant.size() > 0) factor.constant[0] = values[0].get<double>();
  }
  if (variance.correlated() != nullptr) {
    const CorrelationStructure& structure = variance.correlated()->structure();
    VectorXd natural(structure.parameter_count());
    for (Index k = 0; k < natural.size(); ++k) {
      natural[k] = reference["correlation_parameters"][static_cast<std::size_t>(k)].get<double>();
    }
    estimate.correlation = structure.estimate(structure.unconstrained(natural));
  }
  return estimate;
}

MatrixXd matrix_of(const json& rows) {
  const auto size = static_cast<Index>(rows.size());
  MatrixXd result(size, size);
  for (Index i = 0; i < size; ++i) {
    for (Index j = 0; j < size; ++j) {
      result(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)].get<double>();
    }
  }
  return result;
}

MarginalPoint point_of(const json& reference,
                       const NonlinearModel& model,
                       const VarianceModel& variance) {
  VectorXd beta(model.coefficient_count());
  for (const auto& [name, value] : reference["fixed"].items()) {
    beta[model.coefficient_index(name)] = value.get<double>();
  }
  std::vector<MatrixXd> factors;
  for (const auto& random : reference["random"].items()) {
    factors.emplace_back(matrix_of(random.value()["covariance"]).llt().matrixL());
  }
  const VectorXd parameters = variance.parameters(estimate_of(reference, variance));
  const double sigma = reference["sigma"].get<double>() / variance.sigma_factor(parameters);
  return {.observation = {.beta = beta, .variance = parameters, .log_sigma = std::log(sigma)},
          .factors = factors};
}

double log_likelihood(const json& reference, Curvature curvature, int points) {
  const data::Table table =
      data::read_csv_table(test::reference_data(reference["data"].get<std::string>()));
  const ModelSpecification specification = specified(reference, table);
  const NonlinearModel model(specification, table);
  const VarianceModel variance(specification.variance, VarianceData::of(model));
  MarginalLikelihood likelihood(model, variance, curvature, points);
  return -likelihood.evaluate(point_of(reference, model, variance), false).minus_log_likelihood;
}

}  // namespace

TEST_CASE("marginal likelihoods agree with their definitions") {
  const json file = expected("marginal_values");
  for (const json& reference : file.at("fits")) {
    const json& values = reference["logLik"];
    INFO(reference["id"].get<std::string>());
    // R's sums over about a thousand trees round at 1e-12 of the value.
    const auto check = [&](const char* name, Curvature curvature, int points) {
      if (!values.contains(name)) return;
      INFO(name);
      CHECK(log_likelihood(reference, curvature, points) ==
            Approx(values[name].get<double>()).epsilon(1e-11));
    };
    check("foce", Curvature::kFirstOrder, 1);
    check("focei", Curvature::kExpected, 1);
    check("laplace", Curvature::kFull, 1);
    check("agq_3", Curvature::kFull, 3);
    check("agq_7", Curvature::kFull, 7);
    check("agq_15", Curvature::kFull, 15);
  }
}

TEST_CASE("fifteen points of quadrature give the integral over the random effects") {
  const json file = expected("marginal_values");
  for (const json& reference : file.at("fits")) {
    if (!reference["logLik"].contains("integral")) continue;
    INFO(reference["id"].get<std::string>());
    // The difference is the error of the rule, largest for the widest distribution of effects.
    CHECK(log_likelihood(reference, Curvature::kFull, 15) ==
          Approx(reference["logLik"]["integral"].get<double>()).margin(1e-6));
  }
}

TEST_CASE("maxima of marginal likelihoods are those of their definitions") {
  const json file = expected(GENERATE("marginal_optima", "marginal_correlated"));
  for (const json& reference : file.at("fits")) {
    const auto name = reference["method"].get<std::string>();
    INFO(reference["id"].get<std::string>() << " by " << name);
    const data::Table table =
        data::read_csv_table(test::reference_data(reference["data"].get<std::string>()));
    FitModelOptions options{.method = Method::kQuadrature, .quadrature_points = 25};
    // The exact integral is reached by quadrature with many points.
    const bool is_integral = name == "exact" || name.starts_with("agq");
    if (!is_integral) options.method = value_of<Method>(name, "method");
    const FittedModel fit = fit_model(specified(reference, table), table, options).fit;
    CHECK(fit.convergence.converged());
    CHECK(fit.log_likelihood == Approx(reference["logLik"].get<double>()).epsilon(1e-10));
    const Eigen::VectorXd errors = fit.standard_errors();
    for (const auto& [coefficient, value] : reference["estimates"].items()) {
      INFO(coefficient);
      const Index j =
          std::ranges::find(fit.coefficient_names, coefficient) - fit.coefficient_names.begin();
      const double error = reference["std_errors"][coefficient].get<double>();
      // Where the likelihood is flat, both searches stop within 1e-5 standard errors.
      CHECK(fit.estimate[j] == Approx(value.get<double>()).margin(1e-5 * error));
      CHECK(errors[j] == Approx(error).epsilon(1e-4));
    }
    if (reference.contains("correlation")) {
      const double value = reference["correlation_parameters"].begin()->get<double>();
      CHECK(fit.variance.correlation->values[0] == Approx(value).epsilon(1e-4));
    }
    const MatrixXd covariance = matrix_of((--reference["random"].end()).value()["covariance"]);
    for (Index k = 0; k < covariance.rows(); ++k) {
      CHECK(fit.random.back().covariance(k, k) == Approx(covariance(k, k)).epsilon(1e-4));
    }
  }
}

TEST_CASE("nested groups have TMB's maximum of Laplace's likelihood") {
  const json file = expected("laplace_nested_tmb");
  for (const json& reference : file.at("fits")) {
    INFO(reference["id"].get<std::string>());
    const data::Table table =
        data::read_csv_table(test::reference_data(reference["data"].get<std::string>()));
    ModelSpecification model = specify_model(reference["formula"].get<std::string>(), {}, table);
    add_random_effects(model, reference["random_text"].get<std::string>(), table);
    model.variance = parse_variance_function(reference["variance"].get<std::string>());
    const FittedModel fit = fit_model(model, table, {.method = Method::kLaplace}).fit;
    CHECK(fit.convergence.converged());
    CHECK(fit.log_likelihood == Approx(reference["logLik"].get<double>()).epsilon(1e-10));
    for (Index j = 0; j < fit.estimate.size(); ++j) {
      const std::string& name = fit.coefficient_names[static_cast<std::size_t>(j)];
      const double error = reference["std_errors"][name].get<double>();
      CHECK(fit.estimate[j] ==
            Approx(reference["estimates"][name].get<double>()).margin(1e-5 * error));
      CHECK(fit.standard_errors()[j] == Approx(error).epsilon(1e-4));
    }
    const MatrixXd of_stands = matrix_of(reference["random"]["stand"]["covariance"]);
    const MatrixXd of_plots = matrix_of(reference["random"]["plot"]["covariance"]);
    CHECK(fit.random.front().covariance(0, 0) == Approx(of_stands(0, 0)).epsilon(1e-4));
    CHECK(fit.random.back().covariance(1, 1) == Approx(of_plots(1, 1)).epsilon(1e-4));
  }
}
