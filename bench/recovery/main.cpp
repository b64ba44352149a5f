// SPDX-License-Identifier: MIT
// Whether fits give back what data were drawn from: bias and coverage over simulated data sets.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "simulated_heights.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

constexpr std::uint64_t kSeed = 95;

struct Arguments {
  std::string method = "lb";
  std::string variance = "power";
  std::size_t data_sets = 500;
  std::size_t plots = 40;
  std::size_t smallest = 20;
  std::size_t largest = 40;
  std::string out{};
};

/// What became of one parameter over the data sets.
struct Recovery {
  std::string name{};
  double truth = 0.0;
  std::vector<double> estimates{};
  std::size_t covered = 0;  ///< 95 % intervals that hold the truth
  bool has_intervals = true;

  void add(double estimate) { estimates.push_back(estimate); }
  void add(double estimate, double error, double quantile) {
    add(estimate);
    if (std::abs(estimate - truth) <= quantile * error) ++covered;
  }
  double mean() const {
    double sum = 0.0;
    for (const double value : estimates) sum += value;
    return sum / static_cast<double>(estimates.size());
  }
  /// Monte Carlo standard error of the mean.
  double mean_error() const {
    double sum = 0.0;
    for (const double value : estimates) sum += (value - mean()) * (value - mean());
    const auto n = static_cast<double>(estimates.size());
    return std::sqrt(sum / (n - 1.0) / n);
  }
  double bias_in_errors() const { return (mean() - truth) / mean_error(); }
  double coverage() const {
    return static_cast<double>(covered) / static_cast<double>(estimates.size());
  }
};

std::vector<Recovery> parameters(const bench::HeightTruth& truth, bool has_power) {
  std::vector<Recovery> result{{"a", truth.fixed[0]},
                               {"b", truth.fixed[1]},
                               {"b:C", truth.fixed[2]},
                               {"sd(a)", std::sqrt(truth.psi(0, 0))},
                               {"sd(b)", std::sqrt(truth.psi(1, 1))},
                               {"cov(a, b)", truth.psi(0, 1)}};
  result.push_back({"sigma", truth.sigma});
  if (has_power) result.push_back({"delta", truth.delta});
  for (std::size_t i = 3; i < result.size(); ++i) result[i].has_intervals = false;
  return result;
}

void add_fit(const fit::FittedModel& fit, std::vector<Recovery>& recoveries) {
  const Eigen::VectorXd errors = fit.standard_errors();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const boost::math::students_t distribution(fit.degrees_of_freedom[i]);
    const double quantile = boost::math::quantile(distribution, 0.975);
    recoveries[static_cast<std::size_t>(i)].add(fit.estimate[i], errors[i], quantile);
  }
  recoveries[3].add(std::sqrt(fit.random.back().covariance(0, 0)));
  recoveries[4].add(std::sqrt(fit.random.back().covariance(1, 1)));
  recoveries[5].add(fit.random.back().covariance(0, 1));
  recoveries[6].add(fit.sigma);
  if (recoveries.size() > 7) recoveries[7].add(fit.variance.delta());
}

void print(const Arguments& arguments,
           const std::vector<Recovery>& recoveries,
           std::size_t failed) {
  fmt::print(
      "{} with variance {}: {} data sets of {} plots with {} to {} trees, {} not converged\n\n",
      arguments.method,
      arguments.variance,
      arguments.data_sets,
      arguments.plots,
      arguments.smallest,
      arguments.largest,
      failed);
  fmt::print("| parameter | truth | mean | bias in Monte Carlo errors | coverage |\n");
  fmt::print("|---|---|---|---|---|\n");
  for (const Recovery& one : recoveries) {
    fmt::print("| {} | {:.6g} | {:.6g} | {:+.1f} | {} |\n",
               one.name,
               one.truth,
               one.mean(),
               one.bias_in_errors(),
               one.has_intervals ? fmt::format("{:.1f} %", 100.0 * one.coverage()) : "");
  }
}

json to_json(const std::vector<Recovery>& recoveries) {
  json result = json::array();
  for (const Recovery& one : recoveries) {
    json entry = {{"parameter", one.name},
                  {"truth", one.truth},
                  {"mean", one.mean()},
                  {"mean_error", one.mean_error()}};
    if (one.has_intervals) entry["coverage"] = one.coverage();
    result.push_back(entry);
  }
  return result;
}

void run(const Arguments& arguments) {
  const bool has_power = arguments.variance == "power";
  const bench::HeightTruth truth = bench::HeightTruth::ordinary(has_power);
  fit::FitModelOptions options;
  options.method = fit::parse_method(arguments.method);
  std::vector<Recovery> recoveries = parameters(truth, has_power);
  std::size_t failed = 0;
  for (std::size_t number = 0; number < arguments.data_sets; ++number) {
    const data::Table table = bench::simulated_heights(
        truth, arguments.plots, arguments.smallest, arguments.largest, kSeed, number);
    const fit::FitResult result = fit::fit_model(
        bench::height_model("a + b | plot", arguments.variance, table), table, options);
    if (result.fit.convergence.converged()) {
      add_fit(result.fit, recoveries);
    } else {
      ++failed;
    }
  }
  if (arguments.data_sets < failed + 2) throw NumericalError("too few fits converged to speak of");
  print(arguments, recoveries, failed);
  if (!arguments.out.empty()) {
    bench::write_json({{"method", arguments.method},
                       {"variance", arguments.variance},
                       {"data_sets", arguments.data_sets},
                       {"not_converged", failed},
                       {"parameters", to_json(recoveries)}},
                      arguments.out);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Fits data sets of known truth and prints bias and coverage of 95 % t intervals."};
  Arguments arguments;
  app.add_option("--method", arguments.method, "method of the fits")->capture_default_str();
  app.add_option("--variance", arguments.variance, "none or power")
      ->check(CLI::IsMember({"none", "power"}))
      ->capture_default_str();
  app.add_option("--data-sets", arguments.data_sets, "how many")->capture_default_str();
  app.add_option("--plots", arguments.plots, "of each data set")->capture_default_str();
  app.add_option("--smallest", arguments.smallest, "least trees of a plot")->capture_default_str();
  app.add_option("--largest", arguments.largest, "most trees of a plot")->capture_default_str();
  app.add_option("--out", arguments.out, "file for the figures as JSON");
  CLI11_PARSE(app, argc, argv);
  return silvafit::bench::exit_status([&] { run(arguments); });
}
