// SPDX-License-Identifier: MIT
// The settings of inventories, structural units, sampled plots and studies, each described once.
#pragma once

#include "silvafit/data/setting.hpp"
#include "silvafit/study/study_configuration.hpp"

namespace silvafit::study {

using data::Same;

template <Same<RowSettings> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  using data::SettingForm;
  visit(Setting("where",
                settings.where,
                "Rows to use, such as 'species == \"SM\" && dbh > 7'; the other rows are left out "
                "before anything is computed")
            .as(SettingForm::kText, "CONDITION"));
  visit(Setting("visits",
                settings.visits,
                "Columns of one measure at several times, which become a row for each time with a "
                "column year, such as dbh=DBH_{year},h=H_{year}")
            .as(SettingForm::kMapping, "NAME=PATTERN,..."));
}

template <Same<ReadingSettings> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  using data::SettingForm;
  visit(Setting("columns",
                settings.columns,
                "Names or formulas of the columns, such as dbh=DBH_cm,h=Height,x=xk/10")
            .as(SettingForm::kMapping, "NAME=COLUMN,..."));
  visit(Setting("trust_units",
                settings.trust_units,
                "Do not check whether a column, or some plots, have another unit"));
  visit(Setting("missing",
                settings.missing,
                "Further texts or numbers for missing values, such as -88,unknown (known are empty "
                "fields, NA, -, n/a and similar, -999, and 0 in dbh, h and cw)")
            .type("CODE,..."));
  visit(Setting("fill_down",
                settings.fill_down,
                "Columns whose empty fields have the value above, as in exported merged cells, "
                "such as plot,species")
            .type("COLUMN,..."));
  visit(Setting("dead",
                settings.dead,
                "Standing dead trees, by a column of the status: leave-out; neighbors (they are "
                "neighbors of living trees, but not in summaries or models); include (as living "
                "ones; cut and fallen trees, too)"));
  visit(Setting("alive_codes", settings.alive_codes, "Values of the status that mean alive")
            .type("CODE,..."));
  visit(
      Setting("dead_codes", settings.dead_codes, "Values of the status that mean dead and standing")
          .type("CODE,..."));
  visit(Setting("cut_codes",
                settings.cut_codes,
                "Values of the status that mean cut, fallen or a stump")
            .type("CODE,..."));
  visit(Setting("case_sensitive",
                settings.case_sensitive,
                "Species that differ only in capitals, accents or blanks are different"));
}

template <Same<UnitSettings> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  using data::SettingForm;
  visit(Setting("window",
                settings.window,
                "Area of the inventory in m: GeoJSON, WKT, or CSV with plot and wkt, or plot, x, y "
                "and radius, or plot, x and y of corners in order; or a layer of polygons "
                "(default: the convex hull of the trees)")
            .as(SettingForm::kFile, "FILE"));
  visit(Setting("circle",
                settings.circle,
                "The boundary of every plot is this circle, in coordinates of the plot, such as "
                "0,0,12.62")
            .as(SettingForm::kText, "X,Y,RADIUS"));
  visit(Setting("edge",
                settings.edge,
                "Edge correction: buffer (trees near the boundary are neighbors only), hanisch "
                "(core trees are those whose neighbors are nearer than the boundary, with "
                "weights), torus (opposite sides are joined) or none"));
  visit(Setting("buffer", settings.buffer_m, "Width of the buffer in m")
            .type("M")
            .optional()
            .needs(settings.edge == stand::EdgeCorrection::kBuffer, "`edge=buffer`"));
  visit(Setting("further",
                settings.further,
                "Further indices: CO crown overlap, T size differentiation, Hegyi, BAL basal area "
                "of larger trees, CCF crown competition factor; or all")
            .type("INDEX,..."));
  visit(Setting("per", settings.per, "Search neighbors within each plot or the whole stand"));
  visit(Setting("neighbors", settings.neighbors, "Number of neighbors in a structural unit"));
  visit(Setting("alpha",
                settings.alpha,
                "Limit angle of W in degrees (default: 360 / (neighbors + 1)), for single species "
                "as in 72,SM=60")
            .type("ANGLE,SPECIES=ANGLE,...")
            .names_once('='));
  visit(Setting("dominance", settings.dominance, "Size that U and T compare: dbh, h or cw"));
  visit(Setting("crowding",
                settings.crowding,
                "Crowns in C: mean (half of cw) or facing (radii towards each other)"));
  visit(Setting("competition_radius",
                settings.competition_radius_m,
                "Hegyi: competitors are the trees within this radius in m (default: the neighbors)")
            .type("M")
            .optional()
            .needs(settings.wants("Hegyi"), "`further=Hegyi`"));
  visit(Setting("open_grown",
                settings.open_grown,
                "CCF: crown width in m of an open-grown tree, such as \"0.9 + 0.22*dbh\"")
            .as(SettingForm::kText, "EXPRESSION")
            .needs(settings.wants("CCF"), "`further=CCF`"));
}

template <Same<SamplingSettings> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  using data::SettingForm;
  visit(Setting("plots",
                settings.plots_file,
                "Table of plots, joined by the column plot: area in m2 or radius in m, stratum, "
                "share, slope, x, y and others; CSV, workbook, layer or database")
            .as(SettingForm::kFile, "FILE"));
  visit(Setting("plots_columns",
                settings.plots_columns,
                "Names or formulas of the columns of the table of plots, such as area=SIZE*100")
            .as(SettingForm::kMapping, "NAME=COLUMN,...")
            .needs(settings.has_plots(), "`plots`"));
  visit(Setting("circles",
                settings.circles,
                "Concentric circles: from which dbh in cm trees are counted up to which radius in "
                "m, such as 7=4,15=8,30=12")
            .type("DBH=RADIUS,..."));
  visit(Setting("angle_count",
                settings.angle_count,
                "Plots are angle counts with this basal area factor in m2/ha")
            .type("FACTOR")
            .optional());
  visit(Setting("smallest_dbh",
                settings.smallest_dbh_cm,
                "Angle counts: smallest dbh that is counted in cm (default: the smallest dbh)")
            .type("CM")
            .optional()
            .needs(settings.angle_count > 0.0, "`angle_count`"));
  visit(Setting("expansion",
                settings.expansion,
                "Column with the number of trees per ha that each tree stands for")
            .as(SettingForm::kText, "COLUMN"));
  visit(Setting("expansion_area",
                settings.expansion_area,
                "Hectares of the expansion are those of the whole plot (plot), so that values are "
                "divided by its share, or of the part in the population (part)")
            .one_of({"plot", "part"}));
  visit(Setting("subplots", settings.subplots, "Number of circles of a plot, all of one kind")
            .needs(!settings.circles.empty() || settings.angle_count > 0.0 || settings.has_plots(),
                   "`circles`, `angle_count`, or radii in the table of `plots`"));
  visit(Setting("subplot",
                settings.subplot,
                "Column with the subplot of each tree, within which neighbors are searched")
            .as(SettingForm::kText, "COLUMN"));
  visit(Setting("slope_correction",
                settings.slope_correction,
                "Distances of plots were measured along the slope, a column of the table of plots")
            .needs(settings.has_plots(), "a column slope in the table of `plots`"));
}

template <Same<StudyOptions> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  using data::SettingForm;
  visit(Setting("species", settings.species, "Species to study (default: all with enough trees)")
            .as(SettingForm::kNames, "SPECIES,..."));
  visit(Setting(
      "minimum_trees", settings.minimum_trees, "Minimum number of measured trees of a species"));
  visit(Setting("responses", settings.responses, "Responses to model").type("COLUMN,..."));
  visit(Setting("candidates",
                settings.candidates,
                "Equations by response: entries of the catalogue (silvafit models), or formulas "
                "such as \"h ~ 1.3 + a*dbh^b\" (default: all entries)"));
  visit(Setting("covariates",
                settings.covariates,
                "Covariates of level 2: W, M, U, C, CO, T, Hegyi, BAL, CCF, stems_per_ha, "
                "basal_area_per_ha, quadratic_mean_dbh, dominant_height, or columns of the file")
            .type("COLUMN,..."));
  visit(Setting("covariate_parameters",
                settings.covariate_parameters,
                "Number of parameters that may have covariates: 1 or 2")
            .at_most(2));
  visit(Setting("group", settings.group, "Column of the random effects").type("COLUMN"));
  visit(Setting("period",
                settings.period,
                "Column of the year or date of repeated measurements: the rows of all times are "
                "used, with random effects of the times within the groups")
            .as(SettingForm::kText, "COLUMN"));
  visit(Setting("maximum_random_effects",
                settings.maximum_random_effects,
                "Highest number of coefficients that vary between the groups"));
  visit(Setting("variance_functions",
                settings.variance_functions,
                "Variance functions of the residuals that are tried")
            .type("FUNCTION,..."));
  visit(Setting("criteria",
                settings.criteria,
                "Criterion at each level: aic, aicc, bic, or cv (prediction error for plots left "
                "out)"));
  visit(Setting("choice",
                settings.parsimonious,
                "Choice of random effects and variance functions: best, or parsimonious within "
                "the difference of equally good ones")
            .one_of({"best", "parsimonious"}));
  visit(Setting("equally_good",
                settings.equally_good,
                "Difference of the criterion within which models are equally good")
            .optional());
  visit(Setting("tests",
                settings.needs_tests,
                "Likelihood-ratio tests: required (must be significant) or shown")
            .one_of({"shown", "required"}));
  visit(Setting("significance", settings.significance, "Level of the tests")
            .optional()
            .at_most(1)
            .needs(settings.needs_tests, "`tests=required`"));
  visit(Setting("compared_trees",
                settings.compared_trees,
                "Highest number of trees of a species for comparing candidates; 0: all")
            .optional());
}

template <Same<StudyConfiguration> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  each_setting(settings.study, visit);
  each_setting(settings.reading, visit);
  each_setting(settings.reading.rows, visit);
  each_setting(settings.units, visit);
  each_setting(settings.sampling, visit);
}

}  // namespace silvafit::study
