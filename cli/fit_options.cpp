// SPDX-License-Identifier: MIT
#include "fit_arguments.hpp"

namespace silvafit::cli {

void add_model_options(CLI::App& command, FitArguments& arguments) {
  command
      .add_option(
          "--formula", arguments.formula, "Model, such as \"h ~ 1.3 + a*(1 - exp(-b*dbh))\"")
      ->type_name("FORMULA");
  command
      .add_option(
          "--model",
          arguments.models,
          "Model of the catalogue, such as M4, or all:h for all models of a response; repeatable")
      ->type_name("ID")
      ->allow_extra_args(false);
  command
      .add_option("--parameter",
                  arguments.parameters,
                  "Linear sub-model of a parameter, written as in R: \"b ~ 1 + C\", \"b ~ "
                  "C*species\" (text columns are factors), \"b ~ I(dbh^2)\"; repeatable")
      ->type_name("SUBMODEL")
      ->allow_extra_args(false);
  command
      .add_option(
          "--random",
          arguments.random,
          "Random effects: coefficients and groups, such as \"a + b:C | plot\"; nested: \"a | "
          "stand/plot\" or \"a | stand; a + b | plot\" (\"stand/plot\" also there if labels of "
          "plots "
          "recur in other stands); blocks: \"(a + b) + c | plot\"")
      ->type_name("EFFECTS");
  command.add_option("--covariance",
                     arguments.covariance,
                     "Covariance matrix of the random effects: general (default), diagonal or "
                     "identity; parentheses in --random make blocks");
  command.add_option("--variance",
                     arguments.variance,
                     "Variance function of the residuals: none (default), exponential, power or "
                     "constant-plus-power of the fitted value, or of a column as in power(dbh); by "
                     "stratum as in power(fitted | species); stratum(species); products with *; "
                     "fixed parameters as in power(delta = 0.5)");
}

void add_method_options(CLI::App& command, FitArguments& arguments) {
  command.add_option(
      "--method",
      arguments.method,
      "ols, gnls, lb, foce, focei, laplace or agq (default: lb with random effects, gnls with a "
      "variance function, else ols); see docs/scorecard.md for which to choose");
  command
      .add_option("--agq-points",
                  arguments.quadrature_points,
                  "Quadrature points per random effect for the method agq (default 7)")
      ->check(CLI::Range(1, 100));
  command.add_flag(
      "--reml", arguments.reml, "Restricted maximum likelihood (REML), for lb and gnls");
  command.add_flag("--trace", arguments.trace, "Show the iterations on stderr");
  command.add_flag("--share-groups",
                   arguments.shares_groups,
                   "Each process of mpirun reads the data of its own groups only, for foce, focei, "
                   "laplace and agq (docs/large-inventories.md)");
  command.add_option("--fix", arguments.fixed, "Coefficients fixed at a value, such as c=1")
      ->type_name("NAME=VALUE,...");
  command
      .add_option("--bound",
                  arguments.bounds,
                  "Bounds of coefficients, such as b=0:1,c=0: (one end may be open)")
      ->type_name("NAME=LOW:HIGH,...");
  command
      .add_option("--start",
                  arguments.start,
                  "Start values, such as a=30,b=0.03; mixed fits use them in addition to their own")
      ->type_name("NAME=VALUE,...");
  command
      .add_option(
          "--starts", arguments.spread_starts, "Number of further random starts of a mixed fit")
      ->check(CLI::Range(0, 1000));
}

}  // namespace silvafit::cli
