// SPDX-License-Identifier: MIT
// The settings of models, fits, intervals, bootstrap and cross-validation, each described once.
#pragma once

#include "silvafit/data/setting.hpp"
#include "silvafit/fit/bootstrap.hpp"
#include "silvafit/fit/cross_validation.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/intervals.hpp"
#include "silvafit/fit/model_texts.hpp"

namespace silvafit::fit {

template <data::Same<ModelTexts> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  using data::SettingForm;
  visit(Setting("formula", settings.formula, "Model, such as \"h ~ 1.3 + a*(1 - exp(-b*dbh))\"")
            .type("FORMULA"));
  visit(Setting("parameters",
                settings.sub_models,
                "Linear sub-models of parameters, written as in R: \"b ~ 1 + C\", \"b ~ "
                "C*species\" (text columns are factors), \"b ~ I(dbh^2)\"")
            .as(SettingForm::kRepeatable, "SUBMODEL")
            .option("parameter")
            .names_once('~'));
  visit(Setting("random",
                settings.random,
                "Random effects: coefficients and groups, such as \"a + b:C | plot\"; nested: \"a "
                "| stand/plot\" or \"a | stand; a + b | plot\" (\"stand/plot\" also there if "
                "labels of plots recur in other stands); blocks: \"(a + b) + c | plot\"")
            .type("EFFECTS"));
  visit(
      Setting("covariance",
              settings.covariance,
              "Covariance matrix of the random effects: general (default), diagonal, identity or "
              "compound-symmetry, of all groupings or of each; parentheses in `random` make blocks")
          .type("FORM,...")
          .needs(!settings.random.empty(), "`random`"));
  visit(Setting("variance",
                settings.variance,
                "Variance function of the residuals: none (default), exponential, power or "
                "constant-plus-power of the fitted value, or of a column as in power(dbh); by "
                "stratum as in power(fitted | species); stratum(species); products with *; fixed "
                "parameters as in power(delta = 0.5)")
            .type("FUNCTION"));
  visit(
      Setting("derive",
              settings.derived,
              "Functions of the coefficients, with standard errors and intervals, such as \"h30 = "
              "1.3 + a*(1 - exp(-b*30))\"")
          .as(SettingForm::kRepeatable, "NAME=EXPRESSION"));
  visit(Setting("means",
                settings.means,
                "Factors of sub-models: the estimated marginal mean of each parameter at each of "
                "their levels, with standard errors and intervals")
            .type("COLUMN,..."));
  visit(Setting("correlation",
                settings.correlation,
                "Correlation of the residuals within the groups of the random effects, or of a "
                "column as in \"ar1(year | plot)\": none (default), ar1, ar1(TIME), car1(TIME), "
                "arma(P, Q), compound-symmetry, symmetric; by distance exponential(x, y), "
                "gaussian, spherical, rational-quadratic or linear, with a nugget as in "
                "\"exponential(x, y; nugget)\"")
            .type("STRUCTURE"));
}

template <data::Same<FitModelOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("method",
                settings.method,
                "Method of the fit (default: lb with random effects, gnls with a variance "
                "function, else ols); see docs/fit-command.md for which to choose"));
  visit(Setting("agq_points",
                settings.quadrature_points,
                "Quadrature points per random effect for the method agq")
            .at_most(100)
            .needs(settings.method == Method::kQuadrature, "`method=agq`"));
  visit(Setting("reml",
                settings.reml,
                "Restricted maximum likelihood (REML), for lb and gnls, which it chooses without "
                "random effects"));
  visit(Setting("hold", settings.fixed, "Coefficients that are held at a value, such as c=1")
            .type("NAME=VALUE,...")
            .option("fix"));
  visit(Setting("bounds",
                settings.bounds,
                "Bounds of coefficients, such as b=0:1,c=0: (one end may be open)")
            .type("NAME=LOW:HIGH,...")
            .option("bound"));
  visit(Setting("start",
                settings.start,
                "Start values, such as a=30,b=0.03; mixed fits use them in addition to their own")
            .type("NAME=VALUE,..."));
  visit(Setting("starts", settings.spread_starts, "Number of further random starts of a mixed fit")
            .optional()
            .at_most(1000));
  visit(Setting("maximum_iterations",
                settings.maximum_iterations,
                "Highest number of iterations of lb and gnls"));
}

template <data::Same<IntervalOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("method",
                settings.method,
                "Confidence intervals of all parameters: wald (from standard errors) or profile "
                "(from the profile likelihood)")
            .option("intervals"));
  visit(Setting("level", settings.level, "Level of the intervals").share());
}

template <data::Same<BootstrapOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("replicates",
                settings.replicates,
                "Bootstrap: number of refits for standard errors and intervals of all parameters")
            .type("REPLICATES")
            .at_least(2)
            .at_most(10000000)
            .option("bootstrap"));
  visit(Setting("resample",
                settings.resample,
                "Bootstrap data: parametric (simulated from the fit) or cases (groups drawn with "
                "replacement)")
            .needs(settings.replicates > 0, "`replicates`"));
  visit(Setting("level", settings.level, "Level of the bootstrap intervals")
            .share()
            .option("bootstrap-level")
            .needs(settings.replicates > 0, "`replicates`"));
  visit(Setting("group",
                settings.group,
                "Column of the groups to draw or leave out (default: the groups of the random "
                "effects, the outer ones if nested)")
            .type("COLUMN"));
}

template <data::Same<CrossValidationOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("folds",
                settings.folds,
                "Cross-validation over groups: a number of folds, or leave-one-out")
            .type("FOLDS")
            .or_word("leave-one-out")
            .at_least(2)
            .option("cross-validate"));
  visit(Setting("measured",
                settings.measured,
                "Number of trees per left-out group that are used as measured, to calibrate the "
                "others")
            .optional()
            .option("measured-trees"));
  visit(Setting("group",
                settings.group,
                "Column of the groups to leave out (default: those of the random effects, the "
                "outer ones if nested)")
            .type("COLUMN"));
}

}  // namespace silvafit::fit
