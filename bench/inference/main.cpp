// SPDX-License-Identifier: MIT
// Times whole fits of a mixed height curve on one thread: beside R on the same files, and as data
// grow.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/least_squares.hpp"
#include "simulated_heights.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

constexpr std::uint64_t kSeed = 639;
const char* const kRandom = "a + b | plot";

/// One data set of the comparison with R.
struct Case {
  std::size_t trees;
  std::size_t plots;
  std::string variance;

  std::string name() const { return fmt::format("heights_{}_{}_{}", trees, plots, variance); }
  std::size_t per_plot() const { return trees / plots; }
};

std::vector<Case> cases(bool large) {
  std::vector<Case> result;
  for (const char* variance : {"none", "power"}) {
    result.push_back({1000, 10, variance});
    result.push_back({10000, 200, variance});
    if (large) result.push_back({100000, 2000, variance});
  }
  return result;
}

data::Table table_of(const Case& one) {
  // Sizes of plots differ by half, so that no code can count on equal ones.
  const std::size_t half = one.per_plot() / 2;
  return bench::simulated_heights(bench::HeightTruth::ordinary(one.variance == "power"),
                                  one.plots,
                                  one.per_plot() - half,
                                  one.per_plot() + half,
                                  kSeed,
                                  one.trees);
}

/// Seconds of n exponentials, the least that one pass over the data can cost.
double floor_seconds(const data::Table& table, int repeats) {
  const std::vector<data::Expression> outputs{data::Expression::parse("exp(x)")};
  const data::Program program(outputs, {{.name = "x"}});
  std::vector<double> x(table.numbers("D").begin(), table.numbers("D").end());
  for (double& value : x) value *= -0.035;
  std::vector<double> y(x.size());
  data::Program::Workspace workspace;
  const std::vector<const double*> in{x.data()};
  const std::vector<double*> out{y.data()};
  return bench::median_cpu_seconds(repeats,
                                   [&] { program.evaluate(in, x.size(), out, workspace); });
}

/// Those of the named methods that this program has.
std::vector<fit::Method> known_methods(const std::vector<std::string>& names) {
  std::vector<fit::Method> methods;
  for (const std::string& name : names) {
    try {
      methods.push_back(fit::parse_method(name));
    } catch (const UsageError& error) {
      std::cerr << "left out: " << error.what() << '\n';
    }
  }
  return methods;
}

fit::MixedEffectsFit mixed_fit(const fit::NonlinearModel& model,
                               const Eigen::VectorXd& start,
                               fit::Method method) {
  switch (method) {
    case fit::Method::kLindstromBates:
      return fit::fit_lindstrom_bates(model, start);
    case fit::Method::kFirstOrder:
      return fit::fit_marginal(model, start, fit::Method::kFirstOrder);
    case fit::Method::kInteraction:
      return fit::fit_marginal(model, start, fit::Method::kInteraction);
    case fit::Method::kQuadrature:
      return fit::fit_marginal(model, start, fit::Method::kQuadrature);
    default:
      return fit::fit_marginal(model, start, fit::Method::kLaplace);
  }
}

/// The time of the mixed model's fit; the least-squares fit that it starts from is not in it, as it
/// is not in R's.
json timed_fit(const data::Table& table,
               const std::string& variance,
               fit::Method method,
               int repeats) {
  const fit::NonlinearModel model(bench::height_model(kRandom, variance, table), table);
  const Eigen::VectorXd start = fit::fit_least_squares(model).estimate;
  fit::MixedEffectsFit fit;
  const double seconds =
      bench::median_cpu_seconds(repeats, [&] { fit = mixed_fit(model, start, method); });
  const double floor = floor_seconds(table, 5);
  return {{"method", fit::method_text(method)},
          {"variance", variance},
          {"trees", table.rows()},
          {"seconds", seconds},
          {"floor_seconds", floor},
          {"floors", seconds / floor},
          {"converged", fit.convergence.converged()},
          {"verdict", fit.convergence.verdict()},
          {"iterations", fit.convergence.iterations},
          {"log_likelihood", fit.log_likelihood}};
}

json compared_cases(const std::filesystem::path& folder,
                    const std::vector<fit::Method>& methods,
                    bool large,
                    int repeats) {
  json results = json::array();
  for (const Case& one : cases(large)) {
    const data::Table table =
        data::read_csv_table(folder / (one.name() + ".csv"), {.text_columns = {"plot"}});
    for (const fit::Method method : methods) {
      json result = timed_fit(table, one.variance, method, repeats);
      result["name"] = one.name();
      result["plots"] = one.plots;
      results.push_back(result);
      std::cerr << fmt::format("{} {} {:.4f} s\n",
                               one.name(),
                               fit::method_text(method),
                               result["seconds"].get<double>());
    }
  }
  return results;
}

json growth(const std::vector<fit::Method>& methods, std::size_t largest, int repeats) {
  json results = json::array();
  for (const fit::Method method : methods) {
    for (const char* variance : {"none", "power"}) {
      for (std::size_t trees = 1000; trees <= largest; trees *= 10) {
        json result = bench::in_own_process([&] {
          const Case one{trees, trees / 50, variance};
          const data::Table table = table_of(one);
          json inner = timed_fit(table, variance, method, trees > 100000 ? 1 : repeats);
          inner["plots"] = one.plots;
          return inner;
        });
        results.push_back(result);
        std::cerr << fmt::format("{} {} {} trees {:.4f} s\n",
                                 fit::method_text(method),
                                 variance,
                                 result["trees"].get<std::size_t>(),
                                 result["seconds"].get<double>());
      }
    }
  }
  return results;
}

void print_cases(const json& results) {
  fmt::print("\n| trees | plots | variance | method | seconds | floors | log-likelihood |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (const json& one : results) {
    fmt::print("| {} | {} | {} | {} | {:.5f} | {:.0f} | {:.4f}{} |\n",
               one["trees"].get<std::size_t>(),
               one["plots"].get<std::size_t>(),
               one["variance"].get<std::string>(),
               one["method"].get<std::string>(),
               one["seconds"].get<double>(),
               one["floors"].get<double>(),
               one["log_likelihood"].get<double>(),
               one["converged"].get<bool>() ? "" : " (not converged)");
  }
}

/// The exponent of each method and variance, from 10,000 trees on.
void print_growth(const json& results) {
  fmt::print("\n| trees | plots | variance | method | seconds | floors | memory [MB] |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  std::vector<double> trees;
  std::vector<double> seconds;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const json& one = results[i];
    fmt::print("| {} | {} | {} | {} | {:.4f} | {:.0f} | {:.0f} |\n",
               one["trees"].get<std::size_t>(),
               one["plots"].get<std::size_t>(),
               one["variance"].get<std::string>(),
               one["method"].get<std::string>(),
               one["seconds"].get<double>(),
               one["floors"].get<double>(),
               one["peak_rss_mb"].get<double>());
    if (one["plots"].get<std::size_t>() >= 200) {
      trees.push_back(one["trees"].get<double>());
      seconds.push_back(one["seconds"].get<double>());
    }
    const bool is_last = i + 1 == results.size() || results[i + 1]["plots"] == 20;
    if (is_last && trees.size() > 1) {
      fmt::print("| | | {} | {} | n^{:.2f} | | |\n",
                 one["variance"].get<std::string>(),
                 one["method"].get<std::string>(),
                 bench::growth_exponent(trees, seconds));
    }
    if (is_last) {
      trees.clear();
      seconds.clear();
    }
  }
}

struct Arguments {
  std::filesystem::path folder = "build/bench";
  std::vector<std::string> methods{"lb", "laplace"};
  bool large = false;
  bool write = false;
  std::size_t largest = 1000000;
  int repeats = 5;
};

void run(const Arguments& arguments) {
  std::filesystem::create_directories(arguments.folder);
  if (arguments.write) {
    for (const Case& one : cases(arguments.large)) {
      data::write_csv_table(table_of(one), arguments.folder / (one.name() + ".csv"));
    }
    return;
  }
  const std::vector<fit::Method> methods = known_methods(arguments.methods);
  const json compared =
      compared_cases(arguments.folder, methods, arguments.large, arguments.repeats);
  print_cases(compared);
  const json grown = growth(methods, arguments.largest, arguments.repeats);
  print_growth(grown);
  bench::write_json({{"machine", bench::machine()}, {"cases", compared}, {"growth", grown}},
                    arguments.folder / "inference.json");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Times fits of a mixed height curve; CPU seconds, medians."};
  Arguments arguments;
  app.add_option("--folder", arguments.folder, "where the data lie and results go")
      ->capture_default_str();
  app.add_option("--methods", arguments.methods, "methods to time")->capture_default_str();
  app.add_flag("--large", arguments.large, "also 100,000 trees in the comparison with R");
  app.add_flag("--write", arguments.write, "write the data and end");
  app.add_option("--largest", arguments.largest, "most trees of the growth table, 0 for none")
      ->capture_default_str();
  app.add_option("--repeats", arguments.repeats, "least number of fits a median is of")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return silvafit::bench::exit_status([&] { run(arguments); });
}
