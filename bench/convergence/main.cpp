// SPDX-License-Identifier: MIT
// How often fits of small inventories with a near-singular covariance converge, beside R's nlme on
// the same inventories.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "simulated_heights.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

constexpr std::uint64_t kSeed = 5;
constexpr std::size_t kPlots = 10;
constexpr std::size_t kSmallestPlot = 8;
constexpr std::size_t kLargestPlot = 25;

struct Arguments {
  std::filesystem::path folder = "build/bench";
  std::vector<std::string> methods{"lb", "laplace"};
  std::size_t inventories = 500;
};

data::Table inventory(std::size_t number) {
  return bench::simulated_heights(
      bench::HeightTruth::near_singular(), kPlots, kSmallestPlot, kLargestPlot, kSeed, number);
}

/// One file for R: the inventories below each other, numbered.
void write_inventories(const Arguments& arguments) {
  const std::filesystem::path path = arguments.folder / "inventories.csv";
  std::ofstream stream(path);
  stream << "inventory,plot,C,D,H\n";
  for (std::size_t number = 1; number <= arguments.inventories; ++number) {
    const data::Table table = inventory(number);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      stream << number << ',' << table.text("plot")[row];
      for (const char* column : {"C", "D", "H"}) {
        stream << ',' << data::shortest(table.numbers(column)[row]);
      }
      stream << '\n';
    }
  }
  stream.flush();
  if (!stream) throw InputError("cannot be written", {.file = path.string()});
}

json fit_all(const Arguments& arguments, fit::Method method) {
  json fits = json::array();
  for (std::size_t number = 1; number <= arguments.inventories; ++number) {
    const data::Table table = inventory(number);
    fit::FitModelOptions options;
    options.method = method;
    const double begin = bench::cpu_seconds();
    const fit::FittedModel fit =
        fit::fit_model(bench::height_model("a + b + b:C | plot", "none", table), table, options)
            .fit;
    fits.push_back({{"inventory", number},
                    {"converged", fit.convergence.converged()},
                    {"inside", fit.convergence.converged() && !fit.convergence.has_boundary()},
                    {"verdict", fit.convergence.verdict()},
                    {"log_likelihood", fit.log_likelihood},
                    {"seconds", bench::cpu_seconds() - begin}});
  }
  return fits;
}

std::size_t count(const json& fits, const char* what) {
  return static_cast<std::size_t>(
      std::ranges::count_if(fits, [&](const json& fit) { return fit[what].get<bool>(); }));
}

void print_method(const std::string& method, const json& fits) {
  std::vector<double> seconds;
  double longest = 0.0;
  for (const json& fit : fits) {
    seconds.push_back(fit["seconds"].get<double>());
    longest = std::max(longest, seconds.back());
  }
  const std::size_t converged = count(fits, "converged");
  const std::size_t inside = count(fits, "inside");
  fmt::print("| {} | {} | {} ({:.1f} %) | {} | {} | {:.1f} | {:.1f} |\n",
             method,
             fits.size(),
             converged,
             100.0 * static_cast<double>(converged) / static_cast<double>(fits.size()),
             inside,
             converged - inside,
             1000.0 * bench::median(seconds),
             1000.0 * longest);
}

/// A verdict without its numbers, which differ from fit to fit.
std::string reason(const std::string& verdict) {
  return std::regex_replace(verdict, std::regex("[0-9]+(\\.[0-9]+)?(e[-+][0-9]+)?"), "#");
}

/// Why the others did not.
void print_failures(const std::string& method, const json& fits) {
  std::map<std::string, std::vector<std::size_t>> reasons;
  for (const json& fit : fits) {
    if (fit["converged"].get<bool>()) continue;
    reasons[reason(fit["verdict"].get<std::string>())].push_back(
        fit["inventory"].get<std::size_t>());
  }
  for (const auto& [verdict, numbers] : reasons) {
    fmt::print("{}: {} such as inventory {}: {}\n", method, numbers.size(), numbers[0], verdict);
  }
}

void run(const Arguments& arguments) {
  std::filesystem::create_directories(arguments.folder);
  write_inventories(arguments);
  json results;
  for (const std::string& name : arguments.methods) {
    try {
      results[name] = fit_all(arguments, fit::parse_method(name));
    } catch (const UsageError& error) {
      std::cerr << name << " left out: " << error.what() << '\n';
    }
  }
  fmt::print(
      "| method | inventories | converged | not boundary | boundary | median [ms] | longest [ms] "
      "|\n"
      "|---|---|---|---|---|---|---|\n");
  for (const auto& [method, fits] : results.items()) print_method(method, fits);
  for (const auto& [method, fits] : results.items()) print_failures(method, fits);
  bench::write_json(results, (arguments.folder / "convergence.json").string());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Counts verdicts of fits with random effects on a, b and b:C to simulated inventories of 10 "
      "plots with 8 to 25 trees."};
  Arguments arguments;
  app.add_option("--folder", arguments.folder, "where inventories and results go")
      ->capture_default_str();
  app.add_option("--methods", arguments.methods, "methods to fit with")->capture_default_str();
  app.add_option("--inventories", arguments.inventories, "how many")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return silvafit::bench::exit_status([&] { run(arguments); });
}
