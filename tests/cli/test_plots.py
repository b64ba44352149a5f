# SPDX-License-Identifier: MIT
"""Sampled plots and growth from the built program (docs/plots.md)."""

import csv
import json
import math
import pathlib
import random
import unittest

from silvafit_program import ProgramTest

HECTARE = 10000


class SampledPlots(ProgramTest):
    def test_subplots_and_microplots_have_the_factors_of_the_forest_service(self):
        self.write("trees.csv", "plot,subp,tree,species,dbh\n1,1,1,A,5\n1,2,1,A,30\n2,4,1,A,41\n")
        stand = self.run_json("stand", "trees.csv", "--circles", "2.54=2.07264,12.7=7.3152", "--subplots", "4")
        acre = 0.40468564224
        plots = {one["plot"]: one["stems_per_ha"] * acre for one in stand["areas"]}
        # TPA_UNADJ of the FIADB User Guide: 74.965282 and 6.018046 trees per acre.
        self.assertAlmostEqual(plots["1"], 74.965282 + 6.018046, delta=1e-5)
        self.assertAlmostEqual(plots["2"], 6.018046, delta=1e-6)
        # The same as factors of a column.
        self.write("tpa.csv", "plot,tree,species,dbh,TPA_UNADJ\n1,1,A,5,74.965282\n1,2,A,30,6.018046\n2,1,A,41,6.018046\n")
        factors = self.run_json("stand", "tpa.csv", "--columns", "tph=TPA_UNADJ/0.40468564224", "--expansion", "tph")
        self.assertAlmostEqual(factors["all"]["stems_per_ha"], stand["all"]["stems_per_ha"], delta=1e-4)
        self.assertIsNone(factors["areas"][0]["area_ha"])

    def test_areas_of_less_than_a_tree_per_hectare_are_refused(self):
        self.write("trees.csv", "plot,tree,species,dbh,h\n1,1,A,20,15\n1,2,A,30,21\n2,1,A,25,18\n")
        self.write("plots.csv", "plot,area_ha\n1,0.05\n2,500\n")
        for options in (("--plots", "plots.csv"), ("--plot-area", "5000000")):
            error = self.run_program("stand", "trees.csv", *options, status=3).stderr
            self.assertIn("less than one per hectare; areas are in m2", error)
            self.run_program("stand", "trees.csv", *options, "--trust-units")

    def test_a_table_of_plots_has_areas_strata_and_empty_plots(self):
        self.write("trees.csv", "plot,tree,species,dbh,h\n1,1,A,20,15\n1,2,A,30,21\n2,1,A,25,18\n7,1,A,25,18\n")
        self.write("plots.csv", "Plot ID,Area (ha),Stratum,stratum_area\n1,0.04,wet,20\n2,0.04,wet,20\n3,0.05,dry,30\n4,0.05,dry,30\n")
        done = self.run_program("stand", "trees.csv", "--plots", "plots.csv", "--out", "tables")
        self.assertIn("1 plot is not in the table of plots and not counted, because the area is unknown: 7", done.stderr)
        self.assertIn("2 plots of the table have no tree and are counted as empty: 3, 4", done.stderr)
        self.assertIn("table of plots: plot is read from column Plot ID, ", done.stderr)
        with open(self.folder / "tables/strata.csv", newline="") as file:
            strata = {row["stratum"]: row for row in csv.DictReader(file)}
        # 50 and 25 trees per ha in wet, none in dry.
        self.assertAlmostEqual(float(strata["wet"]["stems_per_ha"]), 37.5, delta=1e-9)
        self.assertAlmostEqual(float(strata["wet"]["stems_per_ha_se"]), 12.5, delta=1e-9)
        self.assertAlmostEqual(float(strata["all"]["stems_total"]), 750, delta=1e-9)
        self.assertAlmostEqual(float(strata["all"]["stems_total_se"]), 250, delta=1e-9)

    def test_core_trees_are_within_the_circle_of_the_smallest_dbh(self):
        rows = ["plot,tree,species,x,y,dbh"]
        for tree in range(36):
            x, y = 2 * (tree % 6) - 5, 2 * (tree // 6) - 5
            rows.append(f"1,{tree},A,{x},{y},{10 if math.hypot(x, y) <= 4 else 40}")
        self.write("trees.csv", "\n".join(rows) + "\n")
        done = self.run_program("indices", "trees.csv", "--circles", "7=4,30=12", "--edge", "hanisch")
        self.assertIn("complete only within 4 m of the center", done.stderr)
        core = {row["tree"]: int(row["core"]) for row in csv.DictReader(done.stdout.splitlines())}
        # The 4th neighbor is 2 m away; only the four trees at 1.41 m are more than that from the circle.
        self.assertEqual({tree for tree, is_core in core.items() if is_core}, {"14", "15", "20", "21"})

    def test_designs_and_windows_exclude_each_other(self):
        self.write("trees.csv", "plot,tree,species,dbh\n1,1,A,20\n")
        message = self.run_program("stand", "trees.csv", "--angle-count", "4", "--plot-area", "400", status=2).stderr
        self.assertIn("the sampling design gives the areas", message)
        message = self.run_program("stand", "trees.csv", "--circles", "7:4", status=2).stderr
        self.assertIn("is not DBH=RADIUS", message)


class Growth(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("trees.csv", "plot,tree,species,date,dbh,h,status\n"
                   "1,1,A,2010-07-01,20,15,alive\n1,2,A,2010-07-01,30,21,alive\n1,3,A,2010-07-01,25,18,alive\n"
                   "1,1,A,2015-07-01,22,16,alive\n1,2,A,2015-07-01,,,cut\n1,4,A,2015-07-01,8,7,alive\n")

    def test_fates_and_increments(self):
        growth = self.run_json("stand", "trees.csv", "--growth", "--plot-area", "500")
        self.assertEqual(growth["trees"], {"survivor": 1, "ingrowth": 1, "mortality": 0, "cut": 1, "not found": 1})
        years = 1826 / 365.25
        self.assertAlmostEqual(growth["plots"][0]["years"], years, delta=1e-9)
        self.assertAlmostEqual(growth["plots"][0]["stems"]["cut"], 20 / years, delta=1e-9)
        self.run_program("stand", "trees.csv", "--growth", "--plot-area", "500", "--out", "growth")
        with open(self.folder / "growth/growth_trees.csv", newline="") as file:
            trees = list(csv.DictReader(file))
        self.assertEqual([tree["fate"] for tree in trees], ["survivor", "cut", "not found", "ingrowth"])
        self.assertAlmostEqual(float(trees[0]["id"]), 2 / years, delta=1e-9)

    def test_the_last_visit_is_the_stand(self):
        stand = self.run_json("stand", "trees.csv", "--plot-area", "500")
        self.assertEqual(stand["all"]["trees"], 2)

    def test_growth_needs_two_times(self):
        self.write("once.csv", "plot,tree,species,dbh\n1,1,A,20\n")
        message = self.run_program("stand", "once.csv", "--growth", status=3).stderr
        self.assertIn("--columns year=COLUMN", message)


class RepeatedStudies(ProgramTest):
    """Six plots of 0.04 ha, twice with 15 trees; heights differ between plots and between the years of a plot."""

    def setUp(self):
        super().setUp()
        draw = random.Random(8)
        rows = ["plot,tree,species,year,dbh,h"]
        for plot in range(1, 7):
            limit = draw.gauss(25, 2)
            dbh = [draw.uniform(8, 40) for _ in range(15)]
            for year in (2010, 2020):
                own = limit + draw.gauss(0, 1.5)
                for tree, thickness in enumerate(dbh):
                    height = 1.3 + own * (1 - math.exp(-0.05 * thickness)) + draw.gauss(0, 0.4)
                    rows.append(f"{plot},{tree + 1},SM,{year},{thickness:.1f},{height:.2f}")
                dbh = [thickness + 2 for thickness in dbh]
        self.write("trees.csv", "\n".join(rows) + "\n")
        self.write("plots.csv", "plot,area\n" + "".join(f"{plot},400\n" for plot in range(1, 7)))

    def study(self, out, *arguments):
        return self.run_json("study", "trees.csv", *arguments, "--out", out)["results"][0]

    def test_all_times_are_used_with_periods_and_repeated_by_the_record(self):
        settings = ["--responses", "h", "--minimum-trees", "50", "--plots", "plots.csv"]
        once = self.study("once", *settings)
        self.assertEqual(once["n"], 90)
        both = self.study("both", *settings, "--period", "year")
        self.assertEqual(both["n"], 180)
        self.assertRegex(both["random"], r"\| plot; .* \| plot/year")
        with open(self.folder / "both/tables/species.csv", newline="", encoding="utf-8") as file:
            species = next(csv.DictReader(file))
        self.assertAlmostEqual(float(species["stems_per_ha"]), 15 / 0.04, delta=1e-9)
        with open(self.folder / "both/predictions.csv", newline="", encoding="utf-8") as file:
            predicted = list(csv.DictReader(file))
        self.assertEqual({(row["plot"], row["year"]) for row in predicted}, {(str(plot), year) for plot in range(1, 7) for year in ("2010", "2020")})
        options = json.loads((self.folder / "both/run.json").read_text(encoding="utf-8"))["options"]
        self.assertEqual((options["period"], options["plots"]), ("year", "../plots.csv"))
        self.study("again", "--config", "both/run.json")
        for name in ("library.json", "predictions.csv", "tables/variance_components.csv"):
            self.assertEqual((self.folder / "again" / name).read_bytes(), (self.folder / "both" / name).read_bytes(), name)
        # The library predicts the rows of each time as the study did.
        rows = self.run_program("predict", "both/library.json", "trees.csv", "--level", "conditional").stdout
        for row, own in zip(csv.DictReader(rows.splitlines()), predicted):
            self.assertAlmostEqual(float(row["h_pred"]), float(own["h_conditional"]), delta=1e-3)

    def test_repeated_trees_have_effects_of_their_own(self):
        """Against lme4 (bench/r/repeated_trees.R)."""
        sheets = pathlib.Path(__file__).parent / "sheets"
        expected = json.loads((sheets / "repeated-trees.json").read_text(encoding="utf-8"))
        self.write("trees.csv", (sheets / "repeated-trees.csv").read_text(encoding="utf-8"))
        study = self.study("out", "--responses", "cw", "--variance-functions", "none", "--period", "year")
        self.assertEqual(study["random"], "a | plot; a | plot:tree; a | plot:year")
        library = json.loads((self.folder / "out/library.json").read_text(encoding="utf-8"))
        fit = next(model["fit"] for model in library["models"] if model["role"] == "nlme")
        self.assertAlmostEqual(fit["log_likelihood"], expected["log_likelihood"], delta=1e-6)
        # nlme's covariance with maximum likelihood has the factor N / (N - p); bobyqa ends 1e-6 away.
        factor = math.sqrt(288 / 286)
        self.assertAlmostEqual(fit["fixed"]["b"]["se"] / factor, expected["slope_se"], delta=1e-5 * expected["slope_se"])
        self.assertGreater(fit["fixed"]["b"]["se"], 1.5 * expected["slope_se_without_trees"])
        self.assertAlmostEqual(fit["random"][1]["sd"][0], expected["sd_tree"], delta=1e-5)
        # A new tree of a known plot and year, with the variance between trees in its interval.
        self.write("new.csv", "plot,tree,species,year,dbh\n1,99,fir,2020,22\n1,2,fir,2020,22\n")
        rows = self.run_program("predict", "out/library.json", "new.csv", "--level", "conditional", "--interval", "0.9").stdout
        new, known = csv.DictReader(rows.splitlines())
        self.assertEqual((new["flag"], known["flag"]), ("unknown tree", ""))
        width = [float(row["cw_upper"]) - float(row["cw_lower"]) for row in (new, known)]
        self.assertGreater(width[0], 1.4 * width[1])

    def test_what_cannot_be_a_period_is_refused(self):
        error = self.run_program("study", "trees.csv", "--period", "jahr", "--out", "out", status=3).stderr
        self.assertIn("--period: unknown column 'jahr'", error)
        error = self.run_program("study", "trees.csv", "--period", "plot", "--out", "out", status=2).stderr
        self.assertIn("--period", error)


if __name__ == "__main__":
    unittest.main()
