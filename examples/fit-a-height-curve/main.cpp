// SPDX-License-Identifier: MIT
// A height curve whose coefficients differ between plots, from a CSV file to predictions.
//
//   cmake -S examples/fit-a-height-curve -B height-curve -DCMAKE_PREFIX_PATH=PREFIX
//   cmake --build height-curve
//   height-curve/height_curve examples/fir-mixed/inventory.csv
//
// PREFIX is where `cmake --install build --prefix PREFIX` put silvafit. The model is
//
//   h = mean + e,   mean = 1.3 + a (1 - exp(-b dbh)),   sd(e) = sigma mean^delta
//
// with a and b normal between plots, for the trees of one species, by maximum likelihood with
// Laplace's method. Start values are not needed. The same from the command line:
//
//   silvafit fit examples/fir-mixed/inventory.csv --where 'species == "BHN"' --method laplace
//     --formula "h ~ 1.3 + a*(1 - exp(-b*dbh))" --random "a + b | plot" --variance power
#include <cstdio>
#include <exception>
#include <string>

#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/fit/summary.hpp"

namespace data = silvafit::data;
namespace fit = silvafit::fit;

namespace {

fit::FittedModel fit_heights(const data::Table& trees) {
  const fit::ModelSpecification model = fit::specify_model(
      {.formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))", .random = "a + b | plot", .variance = "power"},
      trees);
  return fit::fit_model(model, trees, {.method = fit::Method::kLaplace}).fit;
}

/// Heights of trees of 30 cm on a plot of the fit and on one that it has not seen.
void print_predictions(const fit::FittedModel& fit) {
  data::TextColumn plots;
  for (const char* plot : {"7", "elsewhere"}) plots.append(plot);
  data::Table trees;
  trees.set("plot", plots);
  trees.set("dbh", {30.0, 30.0});
  const fit::Prediction height = fit::predict(fit, trees, fit::Level::kConditional);
  for (std::size_t row = 0; row < trees.rows(); ++row) {
    const auto i = static_cast<Eigen::Index>(row);
    std::printf("dbh 30 cm, plot %-10s h %.2f m, std. dev. of a tree %.2f m%s\n",
                std::string(plots[row]).c_str(),
                height.value[i],
                height.residual_sd[i],
                height.unknown_terms[row] != 0 ? " (new plot: the population's curve)" : "");
  }
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const char* const file = count > 1 ? arguments[1] : "examples/fir-mixed/inventory.csv";
    const data::Table trees = data::rows_where("species == \"BHN\"", data::read_csv_table(file));
    const fit::FittedModel fit = fit_heights(trees);
    std::puts(fit::summary(fit).c_str());
    print_predictions(fit);
    return fit.convergence.converged() ? 0 : 4;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
