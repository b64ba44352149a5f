// SPDX-License-Identifier: MIT
// Whether fits without start values reach the likelihood that fits from the true values reach,
// where plots differ so much that one curve through all of them says little.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"

using namespace silvafit;

namespace {

constexpr std::uint64_t kSeed = 30;
constexpr double kSigma = 1.2;          ///< [m]
constexpr double kRateVariation = 0.2;  ///< coefficient of variation of b, where it varies
constexpr double kLeastShare = 0.05;    ///< of its mean that a plot's coefficient has at least
constexpr double kSameLogLikelihood = 0.01;
constexpr std::array kVariations{0.3, 0.4, 0.5};  ///< of the asymptote

struct Arguments {
  std::string method = "lb";
  std::size_t data_sets = 45;
};

/// A growth curve with its true coefficients.
struct Curve {
  std::string name{};
  std::string formula{};
  std::map<std::string, double> truth{};
  std::function<double(double a, double b, double d)> height{};
};

std::vector<Curve> curves() {
  return {{"exponential",
           "H ~ 1.3 + a*(1 - exp(-b*D))",
           {{"a", 25.0}, {"b", 0.05}},
           [](double a, double b, double d) { return 1.3 + a * (1.0 - std::exp(-b * d)); }},
          {"Richards",
           "H ~ 1.3 + a*(1 - exp(-b*D))^c",
           {{"a", 25.0}, {"b", 0.06}, {"c", 1.3}},
           [](double a, double b, double d) {
             return 1.3 + a * std::pow(1.0 - std::exp(-b * d), 1.3);
           }},
          {"logistic",
           "H ~ 1.3 + a/(1 + exp(c - b*D))",
           {{"a", 22.0}, {"b", 0.12}, {"c", 1.5}},
           [](double a, double b, double d) { return 1.3 + a / (1.0 + std::exp(1.5 - b * d)); }},
          {"Schumacher",
           "H ~ 1.3 + a*exp(-b/D)",
           {{"a", 28.0}, {"b", 9.0}},
           [](double a, double b, double d) { return 1.3 + a * std::exp(-b / d); }}};
}

double positive(Random& random, double mean, double variation) {
  return random.truncated_normal(mean, variation * mean, kLeastShare * mean, 10.0 * mean);
}

/// 8 to 20 plots of 5 to 20 trees.
data::Table heights(const Curve& curve, double variation, bool rate_varies, Random& random) {
  data::TextColumn plot;
  std::vector<double> dbh;
  std::vector<double> height;
  const std::size_t plots = 8 + random.below(13);
  for (std::size_t p = 0; p < plots; ++p) {
    const double a = positive(random, curve.truth.at("a"), variation);
    const double mean_rate = curve.truth.at("b");
    const double b = rate_varies ? positive(random, mean_rate, kRateVariation) : mean_rate;
    const std::size_t trees = 5 + random.below(16);
    for (std::size_t i = 0; i < trees; ++i) {
      const double d = random.uniform(5.0, 45.0);
      plot.append("P" + std::to_string(p + 1));
      dbh.push_back(d);
      height.push_back(random.normal(curve.height(a, b, d), kSigma));
    }
  }
  data::Table table;
  table.set("plot", plot);
  table.set("D", dbh);
  table.set("H", height);
  return table;
}

/// What became of the sets of a curve, a structure and a variation.
struct Tally {
  std::size_t sets = 0;
  std::size_t converged = 0;  ///< without starts
  std::size_t below = 0;      ///< of these, below the likelihood from the true values
  std::size_t above = 0;      ///< and above it
  std::vector<double> seconds{};
};

void compare(const Curve& curve,
             const std::string& random_effects,
             const data::Table& table,
             const Arguments& arguments,
             Tally& tally) {
  fit::ModelSpecification model = fit::specify_model(curve.formula, {}, table);
  fit::add_random_effects(model, random_effects, table);
  fit::FitModelOptions options{.method = fit::parse_method(arguments.method)};
  const double begin = bench::cpu_seconds();
  const fit::FittedModel searched = fit::fit_model(model, table, options).fit;
  tally.seconds.push_back(bench::cpu_seconds() - begin);
  options.start = curve.truth;
  const fit::FittedModel from_truth = fit::fit_model(model, table, options).fit;
  ++tally.sets;
  if (searched.convergence.converged()) ++tally.converged;
  const double gain = searched.log_likelihood - from_truth.log_likelihood;
  if (!(gain >= -kSameLogLikelihood)) ++tally.below;
  if (gain > kSameLogLikelihood) ++tally.above;
}

void run(const Arguments& arguments) {
  fmt::print(
      "| curve | by plot | asymptote varies by | sets | converged | below | above | "
      "median [ms] | longest [ms] |\n|---|---|---|---|---|---|---|---|---|\n");
  std::uint64_t stream = 0;
  for (const Curve& curve : curves()) {
    for (const std::string varying : {"a", "a + b"}) {
      const bool rate_varies = varying == "a + b";
      for (const double variation : kVariations) {
        Tally tally;
        for (std::size_t number = 0; number < arguments.data_sets; ++number) {
          Random random(kSeed, stream++);
          const data::Table table = heights(curve, variation, rate_varies, random);
          compare(curve, varying + " | plot", table, arguments, tally);
        }
        fmt::print("| {} | {} | {:.0f} % | {} | {} | {} | {} | {:.1f} | {:.1f} |\n",
                   curve.name,
                   varying,
                   100.0 * variation,
                   tally.sets,
                   tally.converged,
                   tally.below,
                   tally.above,
                   1000.0 * bench::median(tally.seconds),
                   1000.0 * *std::ranges::max_element(tally.seconds));
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Fits inventories whose plots' asymptotes vary by 30 to 50 %, without start values and from "
      "the true ones, and counts where the first ends below the second."};
  Arguments arguments;
  app.add_option("--method", arguments.method, "method of the fits")->capture_default_str();
  app.add_option("--data-sets", arguments.data_sets, "of each curve, structure and variation")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return silvafit::bench::exit_status([&] { run(arguments); });
}
