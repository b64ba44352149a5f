// SPDX-License-Identifier: MIT
// How good predictions for new plots are: error by the number of sample trees, and how many trees
// the intervals hold, on plots that the fit has not seen.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/prediction.hpp"
#include "simulated_heights.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

const std::vector<std::size_t> kSampleTrees{0, 1, 3, 5, 10};
const std::vector<double> kCoverages{0.90, 0.95};

struct Arguments {
  std::string data{};
  std::string formula{};
  std::string random = "a + b | plot";
  std::string variance = "power";
  std::string method = "lb";
  std::string where{};  ///< species column and value, "species=SM"
  std::size_t folds = 0;
  std::size_t repeats = 20;
  // Simulated inventories instead of data:
  std::size_t data_sets = 200;
  std::size_t plots = 40;
  std::size_t new_plots = 20;
  std::size_t smallest = 20;
  std::size_t largest = 40;
  std::uint64_t seed = 29;
  unsigned threads = 0;
  std::string out{};
};

/// Errors and intervals of trees that were not measured, for one number of sample trees.
struct Score {
  double trees = 0.0;
  double squares = 0.0;
  double errors = 0.0;
  std::map<double, double> covered{};
  std::map<double, double> above{};

  void add(const Score& other) {
    trees += other.trees;
    squares += other.squares;
    errors += other.errors;
    for (const auto& [coverage, count] : other.covered) covered[coverage] += count;
    for (const auto& [coverage, count] : other.above) above[coverage] += count;
  }
};
using Scores = std::map<std::size_t, Score>;

void add(const Scores& from, Scores& to) {
  for (const auto& [trees, score] : from) to[trees].add(score);
}

/// Rows of a table by the label of a column.
std::map<std::string, std::vector<std::size_t>> rows_by(const data::Table& table,
                                                        const std::string& column) {
  const data::TextColumn labels = table.labels(column);
  std::map<std::string, std::vector<std::size_t>> result;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    result[std::string(labels[row])].push_back(row);
  }
  return result;
}

/// Shuffles with our own random numbers.
void shuffle(std::vector<std::size_t>& values, Random& random) {
  for (std::size_t k = values.size(); k > 1; --k) {
    std::swap(values[k - 1], values[random.below(k)]);
  }
}

/// Predicts all plots of a table `repeats` times, each from trees drawn at random.
Score score_of(const fit::FittedModel& fit,
               const data::Table& plots,
               std::size_t sampled,
               std::size_t repeats,
               Random& random) {
  const std::string group = fit.specification.random.back().group;
  const std::string response = fit.specification.formula.left;
  std::vector<std::size_t> rows;
  std::vector<bool> is_sampled;
  data::TextColumn labels;
  for (auto& [label, of_plot] : rows_by(plots, group)) {
    // The same plots count for all numbers of sample trees.
    if (of_plot.size() <= kSampleTrees.back()) continue;
    for (std::size_t repeat = 0; repeat < repeats; ++repeat) {
      std::vector<std::size_t> order = of_plot;
      shuffle(order, random);
      for (std::size_t k = 0; k < order.size(); ++k) {
        rows.push_back(order[k]);
        is_sampled.push_back(k < sampled);
        labels.append(fmt::format("new {} {}", label, repeat));
      }
    }
  }
  Score score;
  if (rows.empty()) return score;
  data::Table table = plots.select(rows);
  const std::vector<double> truth(table.numbers(response).begin(), table.numbers(response).end());
  std::vector<double> measured = truth;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    if (!is_sampled[k]) measured[k] = data::kMissing;
  }
  table.set(group, labels);
  table.set(response, measured);
  for (const double coverage : kCoverages) {
    const fit::Prediction prediction =
        fit::predict(fit, table, fit::Level::kCalibrated, {.interval = coverage});
    for (std::size_t k = 0; k < truth.size(); ++k) {
      if (is_sampled[k]) continue;
      const auto at = static_cast<Eigen::Index>(k);
      if (truth[k] >= prediction.lower[at] && truth[k] <= prediction.upper[at]) {
        score.covered[coverage] += 1.0;
      }
      if (truth[k] > prediction.upper[at]) score.above[coverage] += 1.0;
      if (coverage != kCoverages.front()) continue;
      const double error = truth[k] - prediction.value[at];
      score.trees += 1.0;
      score.squares += error * error;
      score.errors += error;
    }
  }
  return score;
}

/// Fits some plots and predicts others; nothing where the fit did not converge.
std::optional<Scores> scores_of(const fit::ModelSpecification& model,
                                const data::Table& fitted,
                                const data::Table& others,
                                const Arguments& arguments,
                                std::uint64_t stream) {
  const fit::FittedModel fit =
      fit::fit_model(model, fitted, {.method = fit::parse_method(arguments.method)}).fit;
  if (!fit.convergence.converged()) return std::nullopt;
  Random random(arguments.seed, stream);
  Scores result;
  for (const std::size_t sampled : kSampleTrees) {
    result[sampled] = score_of(fit, others, sampled, arguments.repeats, random);
  }
  return result;
}

fit::ModelSpecification model_of(const Arguments& arguments, const data::Table& table) {
  fit::ModelSpecification model = fit::specify_model(arguments.formula, {}, table);
  fit::add_random_effects(model, arguments.random, table);
  model.variance = fit::parse_variance_function(arguments.variance);
  return model;
}

/// The requested rows of a file that have a response.
data::Table measured_rows(const Arguments& arguments) {
  const data::Table table = data::read_csv_table(arguments.data);
  const std::string response = data::parse_formula(arguments.formula).left;
  const std::size_t equals = arguments.where.find('=');
  std::optional<data::TextColumn> labels;
  if (equals != std::string::npos) labels = table.labels(arguments.where.substr(0, equals));
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (std::isnan(table.numbers(response)[row])) continue;
    if (labels && (*labels)[row] != arguments.where.substr(equals + 1)) continue;
    rows.push_back(row);
  }
  return table.select(rows);
}

struct Total {
  Scores scores{};
  /// Standard errors of coverages, by number of sample trees: trees of one plot, or plots of one
  /// fit, are no independent draws.
  std::map<std::size_t, std::map<double, double>> coverage_errors{};
  std::size_t fits = 0;
  std::size_t failed = 0;
};

Total sum_of(const std::vector<std::optional<Scores>>& parts) {
  Total total{.fits = parts.size()};
  for (const auto& part : parts) {
    if (part) {
      add(*part, total.scores);
    } else {
      ++total.failed;
    }
  }
  for (const auto& [sampled, score] : total.scores) {
    for (const double coverage : kCoverages) {
      const double share = score.covered.at(coverage) / score.trees;
      double squares = 0.0;
      for (const auto& part : parts) {
        if (!part || part->at(sampled).trees == 0.0) continue;
        const Score& one = part->at(sampled);
        const auto held = one.covered.find(coverage);
        const double excess = (held == one.covered.end() ? 0.0 : held->second) - share * one.trees;
        squares += excess * excess;
      }
      total.coverage_errors[sampled][coverage] = std::sqrt(squares) / score.trees;
    }
  }
  return total;
}

/// Leaves plots out: one at a time, or those of each fold.
Total leave_out(const Arguments& arguments) {
  const data::Table table = measured_rows(arguments);
  const fit::ModelSpecification model = model_of(arguments, table);
  const auto plots = rows_by(table, model.random.back().group);
  std::vector<std::vector<std::size_t>> of_plot;
  for (const auto& [label, rows] : plots) of_plot.push_back(rows);
  std::vector<std::size_t> order(of_plot.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  Random random(arguments.seed);
  shuffle(order, random);
  const std::size_t folds = arguments.folds == 0 ? order.size() : arguments.folds;
  std::vector<std::optional<Scores>> parts(folds);
  parallel_for(folds, arguments.threads, [&](std::size_t fold) {
    std::vector<std::size_t> kept;
    std::vector<std::size_t> left;
    for (std::size_t k = 0; k < order.size(); ++k) {
      const std::vector<std::size_t>& rows = of_plot[order[k]];
      auto& target = k % folds == fold ? left : kept;
      target.insert(target.end(), rows.begin(), rows.end());
    }
    parts[fold] = scores_of(model, table.select(kept), table.select(left), arguments, 1 + fold);
  });
  return sum_of(parts);
}

/// Draws inventories whose first plots are fitted and whose others are new.
Total simulated(const Arguments& arguments) {
  const bench::HeightTruth truth = bench::HeightTruth::ordinary(arguments.variance == "power");
  std::vector<std::optional<Scores>> parts(arguments.data_sets);
  parallel_for(arguments.data_sets, arguments.threads, [&](std::size_t number) {
    const data::Table table = bench::simulated_heights(truth,
                                                       arguments.plots + arguments.new_plots,
                                                       arguments.smallest,
                                                       arguments.largest,
                                                       arguments.seed,
                                                       number);
    std::vector<std::size_t> kept;
    std::vector<std::size_t> left;
    std::size_t plot = 0;
    const data::TextColumn labels = table.labels("plot");
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (row > 0 && labels[row] != labels[row - 1]) ++plot;
      (plot < arguments.plots ? kept : left).push_back(row);
    }
    parts[number] = scores_of(bench::height_model(arguments.random, arguments.variance, table),
                              table.select(kept),
                              table.select(left),
                              arguments,
                              number);
  });
  return sum_of(parts);
}

json to_json(const Total& total) {
  json result{{"fits", total.fits}, {"not_converged", total.failed}, {"scores", json::array()}};
  for (const auto& [trees, score] : total.scores) {
    json entry{{"sample_trees", trees},
               {"predictions", score.trees},
               {"rmse", std::sqrt(score.squares / score.trees)},
               {"mean_error", score.errors / score.trees}};
    for (const auto& [coverage, count] : score.covered) {
      entry["coverage"][fmt::format("{}", coverage)] = count / score.trees;
      entry["coverage_error"][fmt::format("{}", coverage)] =
          total.coverage_errors.at(trees).at(coverage);
    }
    result["scores"].push_back(entry);
  }
  return result;
}

void print(const Total& total) {
  fmt::print("{} fits, {} not converged\n", total.fits, total.failed);
  fmt::print("{:>12} {:>12} {:>8} {:>8}", "sample trees", "predictions", "RMSE", "mean e");
  for (const double coverage : kCoverages)
    fmt::print(" {:>8} {:>8} {:>8}", coverage, "error", "above");
  fmt::print("\n");
  for (const auto& [trees, score] : total.scores) {
    fmt::print("{:>12} {:>12} {:>8.3f} {:>8.3f}",
               trees,
               score.trees,
               std::sqrt(score.squares / score.trees),
               score.errors / score.trees);
    for (const double coverage : kCoverages) {
      fmt::print(" {:>8.4f} {:>8.4f} {:>8.4f}",
                 score.covered.at(coverage) / score.trees,
                 total.coverage_errors.at(trees).at(coverage),
                 score.above.contains(coverage) ? score.above.at(coverage) / score.trees : 0.0);
    }
    fmt::print("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Predicts plots that a fit has not seen from 0, 1, 3, 5 and 10 of their trees: root mean "
      "squared error, and the share of the other trees that intervals of 90 and 95 % hold."};
  Arguments arguments;
  app.add_option("--data", arguments.data, "CSV file; without it, inventories are simulated");
  app.add_option("--formula", arguments.formula, "of the model, with --data");
  app.add_option("--random", arguments.random, "random effects")->capture_default_str();
  app.add_option("--variance", arguments.variance, "variance function")->capture_default_str();
  app.add_option("--method", arguments.method, "method of the fits")->capture_default_str();
  app.add_option("--where", arguments.where, "rows to use, such as species=SM");
  app.add_option("--folds", arguments.folds, "of plots that are left out together (0: one by one)");
  app.add_option("--repeats", arguments.repeats, "draws of sample trees a plot")
      ->capture_default_str();
  app.add_option("--data-sets", arguments.data_sets, "simulated ones")->capture_default_str();
  app.add_option("--plots", arguments.plots, "that are fitted, of a simulated one")
      ->capture_default_str();
  app.add_option("--new-plots", arguments.new_plots, "that are predicted")->capture_default_str();
  app.add_option("--smallest", arguments.smallest, "least trees of a plot")->capture_default_str();
  app.add_option("--largest", arguments.largest, "most trees of a plot")->capture_default_str();
  app.add_option("--seed", arguments.seed)->capture_default_str();
  app.add_option("--threads", arguments.threads, "0: all cores")->capture_default_str();
  app.add_option("--out", arguments.out, "file for the figures as JSON");
  CLI11_PARSE(app, argc, argv);
  return silvafit::bench::exit_status([&] {
    const Total total = arguments.data.empty() ? simulated(arguments) : leave_out(arguments);
    print(total);
    if (!arguments.out.empty()) bench::write_json(to_json(total), arguments.out);
  });
}
