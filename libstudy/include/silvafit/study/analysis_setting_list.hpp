// SPDX-License-Identifier: MIT
// The settings of stand tables, equations, predictions, imputation, pages and tiles, each described
// once. Those of reading, structural units and sampled plots are in setting_list.hpp.
#pragma once

#include "silvafit/data/setting.hpp"
#include "silvafit/study/impute.hpp"
#include "silvafit/study/predict_table.hpp"
#include "silvafit/study/scenes.hpp"
#include "silvafit/study/stand_summary.hpp"
#include "silvafit/study/tiles.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/view_data.hpp"

namespace silvafit::study {

template <data::Same<StandOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  auto& report = settings.report;
  visit(Setting("layers", report.species.layers.bounds_m, "Limits of the height layers in m"));
  visit(Setting("quadrat",
                report.species.quadrat_m,
                "Side of the quadrats for species frequencies in m (default: the plots; 10 m if "
                "there is one plot)")
            .type("M")
            .optional());
  visit(Setting("dominant_trees",
                report.species.dominant_trees_per_ha,
                "Number of thickest trees per ha for the dominant height"));
  visit(Setting("class_width", report.class_width_cm, "Width of a diameter class in cm"));
  visit(Setting("plot_area", report.plot_area_m2, "Area of every plot in m2, instead of a window")
            .type("M2"));
  visit(Setting("stratum", report.stratum, "Column with the stratum of each plot").type("COLUMN"));
  visit(Setting("stratum_areas",
                report.stratum_areas_ha,
                "Areas of the strata in ha, for totals, such as A=120,B=33.5")
            .type("STRATUM=HA,...")
            .option("stratum-area"));
  visit(Setting("post_stratified",
                report.strata.are_posterior,
                "Plots were assigned to strata after they were chosen: variances of "
                "post-stratification, as FIA's"));
  visit(Setting("finite_population",
                report.strata.is_finite,
                "Reduce variances by the share of each stratum's area that plots cover"));
  visit(Setting("totals",
                settings.totals,
                "Numeric columns of the trees whose means and totals are estimated as those of "
                "the basal area, such as VOLCFNET,DRYBIO_AG")
            .type("COLUMN,..."));
  visit(Setting("thinning",
                settings.thinning,
                "Show the stand before and after a thinning: below=20 or above=20 (m2/ha that "
                "remain; the thinnest or thickest trees are removed), or marked=COLUMN")
            .type("RULE"));
  visit(Setting("site_index",
                settings.site_index,
                "Site index by a published curve, from the dominant height and the column age of "
                "the trees, such as elfving-kiviste-1997")
            .type("ID"));
  visit(Setting("by",
                report.by,
                "Estimates with standard errors of the trees of each kind: species, dbh (diameter "
                "classes) or other columns, such as species,dbh")
            .type("COLUMN,..."));
}

template <data::Same<EquationSettings> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("equations",
                settings.equations,
                "Equations of volume, biomass and carbon, for all or single species, such as "
                "laasasenaho-pine,B=taper; taper is the volume by the taper equation that trees "
                "are drawn with")
            .type("[SPECIES=]ID,..."));
  visit(Setting("equation_files",
                settings.files,
                "Files of further equations (JSON, schema silvafit-tree-equations/1)")
            .as(data::SettingForm::kRepeatable, "FILE.json")
            .option("equation-file")
            .needs(!settings.equations.empty(), "`equations`"));
}

template <data::Same<PredictionSettings> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  const bool is_calibrated = settings.level == fit::Level::kCalibrated;
  visit(Setting("level",
                settings.level,
                "population: random effects 0 (b = 0); conditional: random effects of the fit; "
                "calibrated: random effects from the trees measured in the file; marginal: mean "
                "over all groups"));
  visit(Setting("new_groups",
                settings.new_groups,
                "Conditional predictions for groups that are not in the fit, and calibrated "
                "predictions for such groups without a measured tree")
            .needs(is_calibrated || settings.level == fit::Level::kConditional,
                   "`level=conditional` or calibrated"));
  visit(Setting("seen_groups",
                settings.seen_groups,
                "Calibrated predictions for groups of the fit: use the random effects of the fit "
                "(fitted), only the trees of the file (new), or both (combined)")
            .needs(is_calibrated, "`level=calibrated`"));
  visit(
      Setting("coverage", settings.interval, "Add interval limits with this coverage, such as 0.95")
          .type("LEVEL")
          .share()
          .option("interval"));
  visit(Setting("interval",
                settings.interval_kind,
                "prediction: for the value of a tree; confidence: for the mean of such trees "
                "(default: prediction for limits, confidence for standard errors without limits)")
            .option("interval-kind")
            .needs(settings.wants_errors(), "`coverage` or `standard_errors`"));
  visit(Setting("standard_errors",
                settings.standard_errors,
                "Add the standard error of the kind that `interval` selects, which is that of the "
                "mean unless there are limits or `interval` is prediction"));
  visit(Setting("role",
                settings.role,
                "Which models of a study to use (default: nlme, where a model whose columns are "
                "not all in the file is replaced by the next simpler one)")
            .one_of({kRoles.begin(), kRoles.end()}));
}

template <data::Same<ImputeOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("response", settings.response, "Column to fill in").type("COLUMN"));
  visit(Setting("models",
                settings.models,
                "Models of the catalogue, or all:h; the one with the lowest AIC is used (default: "
                "Naslund's curve for h, else all models of the response)")
            .as(data::SettingForm::kRepeatable, "ID")
            .option("model"));
  visit(Setting("formula", settings.formula, "A formula instead of a model of the catalogue")
            .type("FORMULA"));
  visit(Setting("random",
                settings.random,
                "Random effects such as \"a + b | plot\", or none (default: on the first two "
                "coefficients, fewer if that does not converge)")
            .type("EFFECTS"));
  visit(Setting("variance", settings.variance, "Variance function, as in fit (default: power(dbh))")
            .type("FUNCTION"));
  visit(Setting("method", settings.method, "Method, as in fit (default: lb)"));
  visit(Setting("group", settings.group, "Column of the plots (default: plot)").type("COLUMN"));
  visit(Setting("by", settings.by, "Column whose values get separate models, such as species")
            .type("COLUMN"));
  visit(Setting("minimum_trees",
                settings.minimum_trees,
                "Minimum number of measured trees for a separate model; the others share one model "
                "for all trees")
            .needs(!settings.by.empty(), "`by`"));
  visit(Setting("add_residual",
                settings.add_residual,
                "Add a random residual to imputed values, and random effects to plots without "
                "measured trees"));
  visit(Setting("coverage",
                settings.interval,
                "Add limits of prediction intervals of imputed values with this coverage, such as "
                "0.95")
            .type("LEVEL")
            .share()
            .option("interval"));
}

template <data::Same<ViewOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("plots", settings.plots, "Show these plots only")
            .as(data::SettingForm::kNames, "PLOT,...")
            .option("plot"));
  visit(Setting("mark",
                settings.mark,
                "Show the stand before and after a thinning side by side, which removes the trees "
                "with a number other than 0 in this column")
            .type("COLUMN"));
  visit(Setting("title", settings.title, "Headline (default: the name)"));
  visit(Setting("models",
                settings.models_per_preset,
                "Number of models that the trees of a species preset share"));
  visit(Setting("lod", settings.levels, "Levels of detail in the page, 0 (finest) to 3"));
  visit(Setting("textures",
                settings.textures,
                "Pictures of bark and shoots; plain: leaves as polygons in plain colors")
            .option("plain"));
  visit(Setting("season", settings.season, "Colors of leaves; deciduous trees are bare in winter"));
}

template <data::Same<TileSettings> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("size", settings.size_m, "Side of a tile in m").type("M"));
  visit(Setting("halo",
                settings.halo_m,
                "Width of the strip around a tile in m, whose trees are its neighbors")
            .type("M")
            .optional());
}

template <data::Same<SceneOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  visit(Setting("species", settings.species, "Species of the reference trees").type("NAME,..."));
  visit(Setting("dbh",
                settings.dbh_cm,
                "DBH of the reference trees in cm (default: the most frequent in the inventory)")
            .type("SPECIES=CM,..."));
  visit(Setting(
            "group", settings.group, "Predict with the random effects of this plot (default: none)")
            .type("PLOT"));
  visit(Setting("role", settings.role, "Which models of a study to use")
            .one_of({kRoles.begin(), kRoles.end()}));
  visit(Setting("uniform_angle",
                settings.uniform_angle_index,
                "W of the scenes if the models do not depend on it")
            .optional());
  visit(Setting("spacing", settings.spacing_m, "Distance between the centers of the scenes in m")
            .type("M"));
}

}  // namespace silvafit::study
