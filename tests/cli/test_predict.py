# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit predict`."""

import csv
import io
import json
import math
import unittest
from pathlib import Path

from silvafit_program import ProgramTest, stand_csv

EXAMPLES = Path(__file__).parents[2] / "examples"
MEYER = "h ~ 1.3 + a*(1 - exp(-b*dbh))"
NEW = ('plot,tree,note,dbh,species\n'
       '01,1,"as, is",10.50,SM\n'
       '1,2,,20,SM\n'
       '99,3,x,30,SM\n'
       '02,4,x,,SM\n'
       '02,5,x,500,SM\n')


class Predictions(ProgramTest):
    def fit(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", MEYER, "--random", "a | plot")
        self.write("fit.json", json.dumps(fit))
        self.write("new.csv", NEW)
        return fit

    def predict(self, *arguments):
        output = self.run_program("predict", "fit.json", "new.csv", "--digits", "17", *arguments).stdout
        return list(csv.DictReader(io.StringIO(output)))

    def height(self, fit, dbh, plot=None):
        a = fit["fixed"]["a"]["estimate"] + (fit["random"][0]["eblup"][plot]["a"] if plot else 0.0)
        return 1.3 + a * (1 - math.exp(-fit["fixed"]["b"]["estimate"] * dbh))

    def calibrated(self, new, *arguments):
        self.fit()
        self.write("plots.csv", new)
        output = self.run_program("predict", "fit.json", "plots.csv", "--level", "calibrated", "--digits", "17",
                                  *arguments).stdout
        return output, list(csv.DictReader(io.StringIO(output)))

    def test_numbers_that_are_names_are_the_same_names_in_new_data(self):
        # The text 01 becomes the number 1 nowhere: strata and text matches of the fit are found again.
        lines = stand_csv().splitlines()
        rows = [line + (",01" if i % 2 else ",02") for i, line in enumerate(lines[1:])]
        self.write("coded.csv", "\n".join([lines[0] + ",code", *rows]) + "\n")
        fit = self.run_json("fit", "coded.csv", "--formula", MEYER, "--parameter", 'a ~ 1 + (code == "01")',
                            "--variance", "stratum(code)")
        self.write("fit.json", json.dumps(fit))
        first = fit["fixed"]["a"]["estimate"]
        other = fit["fixed"]['a:(code == "01")']["estimate"]
        curve = 1 - math.exp(-fit["fixed"]["b"]["estimate"] * 20)
        self.write("new.csv", "dbh,code\n20,01\n20,02\n")
        rows = self.predict("--interval", "0.9")
        self.assertAlmostEqual(float(rows[0]["h_pred"]), 1.3 + (first + other) * curve, 9)
        self.assertAlmostEqual(float(rows[1]["h_pred"]), 1.3 + first * curve, 9)
        self.assertTrue(all(row["h_lower"] for row in rows))

    def test_values_outside_the_domain_of_a_model_have_status_3(self):
        self.write("stand.csv", stand_csv())
        self.write("fit.json", json.dumps(self.run_json("fit", "stand.csv", "--model", "M3")))
        self.write("new.csv", "plot,tree,dbh\n1,1,20\n1,2,-5\n")
        error = self.run_program("predict", "fit.json", "new.csv", status=3).stderr
        self.assertIn("new.csv:3: dbh: -5 is outside the domain of the model 0 < dbh (plot 1, tree 2, model M3)",
                      error)

    def test_calibration_uses_the_measured_trees_of_a_new_plot(self):
        fit = self.fit()
        new = 'plot,dbh,h,"a note"\nA,20,25.50,x\nA,30,,"y, z"\nB,30,,\n01,30,40,\n'
        output, rows = self.calibrated(new)
        # One tree of a model that is linear in its random effect: shrinkage of its residual.
        a, b = (fit["fixed"][name]["estimate"] for name in "ab")
        z = 1 - math.exp(-b * 20)
        psi, sigma = fit["random"][0]["covariance"][0][0], fit["sigma"]
        effect = psi * z / (psi * z * z + sigma ** 2) * (25.5 - 1.3 - a * z)
        expected = 1.3 + (a + effect) * (1 - math.exp(-b * 30))
        self.assertAlmostEqual(float(rows[1]["h_pred"]), expected, 8)
        self.assertEqual([row["h_trees"] for row in rows], ["1", "1", "0", "fitted"])
        self.assertAlmostEqual(float(rows[2]["h_pred"]), self.height(fit, 30), 10)
        self.assertEqual(rows[2]["flag"], "no measured h in plot")
        self.assertAlmostEqual(float(rows[3]["h_pred"]), self.height(fit, 30, "01"), 10)
        lines = output.splitlines()
        self.assertEqual(lines[0], 'plot,dbh,h,a note,h_pred,h_trees,flag')
        self.assertTrue(lines[1].startswith("A,20,25.50,x,"))
        self.assertTrue(lines[2].startswith('A,30,,"y, z",'))

    def test_expressions_are_predicted_and_calibrated(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", "log(h - 1.3) ~ a + b*log(dbh)", "--random", "a | plot")
        self.write("fit.json", json.dumps(fit))
        self.write("new.csv", "plot,dbh,h\nA,20,25.5\nA,30,\n")
        rows = self.predict("--level", "calibrated")
        # Shrinkage of one residual of the expression.
        a, b = (fit["fixed"][name]["estimate"] for name in "ab")
        psi, sigma = fit["random"][0]["covariance"][0][0], fit["sigma"]
        effect = psi / (psi + sigma ** 2) * (math.log(25.5 - 1.3) - a - b * math.log(20))
        self.assertAlmostEqual(float(rows[1]["log(h - 1.3)_pred"]), a + effect + b * math.log(30), 10)
        self.write("new.csv", "plot,dbh,h\nA,20,1.2\n")
        self.assertAlmostEqual(float(self.predict("--level", "population")[0]["log(h - 1.3)_pred"]), a + b * math.log(20), 10)
        error = self.run_program("predict", "fit.json", "new.csv", "--level", "calibrated", status=3).stderr
        self.assertIn("new.csv:2: log(h - 1.3): the response is not defined here", error)

    def test_seen_plots_may_count_their_new_trees(self):
        new = "plot,dbh,h\n01,20,35\n01,30,\n"
        by_default = self.calibrated(new)[1][1]
        combined = self.calibrated(new, "--seen-groups", "combined")[1][1]
        alone = self.calibrated(new, "--seen-groups", "new")[1][1]
        # A tree far above the curve pulls the plot up, the more the less is known besides.
        self.assertLess(float(by_default["h_pred"]), float(combined["h_pred"]))
        self.assertLess(float(combined["h_pred"]), float(alone["h_pred"]))
        self.assertEqual(combined["h_trees"], "1")

    def test_intervals_hold_the_prediction_and_shrink_with_what_is_known(self):
        new = "plot,dbh,h\nA,20,25\nA,22,26\nA,30,\nB,30,\n"
        rows = self.calibrated(new, "--interval", "0.95", "--standard-errors")[1]
        width = [float(row["h_upper"]) - float(row["h_lower"]) for row in rows]
        self.assertLess(float(rows[2]["h_lower"]), float(rows[2]["h_pred"]))
        self.assertGreater(float(rows[2]["h_upper"]), float(rows[2]["h_pred"]))
        self.assertLess(width[2], width[3])
        self.assertLess(float(rows[2]["h_se"]), float(rows[3]["h_se"]))
        means = self.calibrated(new, "--interval", "0.95", "--interval-kind", "confidence")[1]
        self.assertLess(float(means[2]["h_upper"]) - float(means[2]["h_lower"]), width[2])
        self.assertNotIn("h_se", means[0])
        narrow = self.calibrated(new, "--interval", "0.5")[1]
        self.assertLess(float(narrow[2]["h_upper"]), float(rows[2]["h_upper"]))
        self.run_program("predict", "fit.json", "new.csv", "--interval", "95", status=2)

    def test_marginal_predictions_average_over_plots(self):
        fit = self.fit()
        rows = self.predict("--level", "marginal")
        # The curve is linear in its random effect: the mean over plots is the typical plot.
        self.assertAlmostEqual(float(rows[0]["h_pred"]), self.height(fit, 10.5), 8)
        new = "plot,dbh,h\nB,30,\n"
        row = self.calibrated(new, "--new-groups", "marginal")[1][0]
        self.assertAlmostEqual(float(row["h_pred"]), self.height(fit, 30), 8)
        self.assertEqual(self.calibrated(new, "--new-groups", "missing")[1][0]["h_pred"], "")
        error = self.run_program("predict", "fit.json", "plots.csv", "--level", "calibrated",
                                 "--new-groups", "error", status=3).stderr
        self.assertIn("no measured tree", error)

    def test_crown_bases_hold_the_error_of_predicted_heights(self):
        header, *lines = stand_csv().splitlines()
        names = header.split(",")
        trees = [dict(zip(names, line.split(","))) for line in lines]
        text = ["plot,dbh,h,hcb"]
        for i, tree in enumerate(trees):
            hcb = float(tree["h"]) / (1 + math.exp(0.4)) + 0.4 * math.sin(7.0 * i)
            text.append(f"{tree['plot']},{tree['dbh']},{tree['h']},{hcb:.2f}")
        self.write("crowns.csv", "\n".join(text) + "\n")
        fits = [self.run_json("fit", "crowns.csv", "--formula", MEYER, "--random", "a | plot"),
                self.run_json("fit", "crowns.csv", "--formula", "hcb ~ h/(1 + exp(c))",
                              "--method", "ols")]
        self.write("both.json", json.dumps({"fits": fits}))
        self.write("trees.csv", "plot,dbh,h\nA,20,\nA,25,27\n")
        expected = self.run_program("predict", "both.json", "trees.csv", "--digits", "17").stdout
        predicted = list(csv.DictReader(io.StringIO(expected)))[0]["h_pred"]
        self.write("known.csv", f"plot,dbh,h\nA,20,{predicted}\nA,25,27\n")
        rows = {}
        for name in ("trees", "known"):
            output = self.run_program("predict", "both.json", name + ".csv", "--interval", "0.9", "--digits",
                                      "17").stdout
            rows[name] = list(csv.DictReader(io.StringIO(output)))
        width = {name: float(found[0]["hcb_upper"]) - float(found[0]["hcb_lower"])
                 for name, found in rows.items()}
        self.assertEqual(rows["trees"][0]["hcb_pred"], rows["known"][0]["hcb_pred"])
        self.assertGreater(width["trees"], width["known"])
        self.assertEqual(rows["trees"][0]["flag"],
                         "h predicted; hcb interval includes the error of h")
        self.assertEqual(rows["trees"][1], rows["known"][1])

    def test_population_is_the_formula_with_fixed_effects(self):
        fit = self.fit()
        rows = self.predict()
        self.assertAlmostEqual(float(rows[0]["h_pred"]), self.height(fit, 10.5), 10)
        self.assertAlmostEqual(float(rows[2]["h_pred"]), self.height(fit, 30), 10)
        self.assertEqual(rows[0]["flag"], "")

    def test_conditional_adds_the_effect_of_the_plot(self):
        fit = self.fit()
        rows = self.predict("--level", "conditional")
        self.assertAlmostEqual(float(rows[0]["h_pred"]), self.height(fit, 10.5, "01"), 10)
        self.assertAlmostEqual(float(rows[2]["h_pred"]), self.height(fit, 30), 10)
        self.assertEqual(rows[2]["flag"], "unknown plot")

    def test_new_groups_may_be_missing_or_refused(self):
        self.fit()
        rows = self.predict("--level", "conditional", "--new-groups", "missing")
        self.assertEqual((rows[2]["h_pred"], rows[2]["flag"]), ("", "unknown plot"))
        error = self.run_program("predict", "fit.json", "new.csv", "--level", "conditional",
                                 "--new-groups", "error", status=3).stderr
        self.assertIn("new.csv:", error)
        self.assertIn("unknown group", error)

    def test_gaps_and_extrapolation_are_flagged(self):
        self.fit()
        rows = self.predict()
        self.assertEqual((rows[3]["h_pred"], rows[3]["flag"]), ("", "missing dbh"))
        self.assertEqual(rows[4]["flag"], "dbh outside fitted range")

    def test_trees_without_an_interval_say_why(self):
        trees = ["dbh,h,noise,species"]
        for i in range(60):
            noise, species = 1 + i % 4, "fir" if i % 3 else "oak"
            error = 0.3 * noise * (2 if species == "oak" else 1) * math.sin(7 * i * i)
            trees.append(f"{10 + i % 20},{3 + 0.8 * (10 + i % 20) + error},{noise},{species}")
        self.write("trees.csv", "\n".join(trees) + "\n")
        fit = self.run_program("fit", "trees.csv", "--formula", "h ~ a + b*dbh", "--json",
                               "--variance", "stratum(species) * power(noise)").stdout
        self.write("fit.json", fit)
        self.write("new.csv", "dbh,noise,species\n20,2,fir\n20,2,elm\n20,2,\n20,,fir\n")
        rows = self.predict("--interval", "0.9")
        reasons = ["", "unknown species", "missing species", "missing noise"]
        self.assertEqual([row["flag"] for row in rows],
                         [reason and "no h interval: " + reason for reason in reasons])
        self.assertEqual([row["h_lower"] != "" for row in rows], [not reason for reason in reasons])
        self.assertEqual(len({row["h_pred"] for row in rows}), 1)
        # Neither the mean nor its interval needs to know how single trees vary.
        self.write("new.csv", "dbh\n20\n")
        self.assertEqual(self.predict()[0]["flag"], "")
        self.assertEqual(self.predict()[0]["h_pred"], rows[0]["h_pred"])
        mean = self.predict("--interval", "0.9", "--interval-kind", "confidence")[0]
        self.assertEqual(mean["flag"], "")
        self.assertLess(float(mean["h_lower"]), float(mean["h_upper"]))
        self.assertEqual(self.predict("--standard-errors", "--interval-kind", "prediction")[0]["flag"],
                         "no h standard error: missing species")
        # Without limits it is that of the mean: t times it are the limits of the mean.
        alone = self.predict("--standard-errors")[0]
        both = self.predict("--standard-errors", "--interval", "0.9", "--interval-kind", "confidence")[0]
        self.assertEqual((alone["flag"], alone["h_se"]), ("", both["h_se"]))

    def test_labels_that_the_fit_has_not_seen_are_flagged(self):
        trees = ["dbh,h,zone,species"]
        for i in range(60):
            zone, species = 1 + i % 2, ("fir", "oak", "elm")[i % 3]
            trees.append(f"{10 + i % 20},{3 + zone + 0.8 * (10 + i % 20) + math.sin(7 * i * i)},{zone},{species}")
        self.write("trees.csv", "\n".join(trees) + "\n")
        self.write("fit.json", self.run_program("fit", "trees.csv", "--formula", "h ~ a + b*dbh", "--json", "--parameter",
                                                'a ~ 1 + species == "oak" + zone == "2"').stdout)
        self.write("new.csv", "dbh,zone,species\n20,1,fir\n20,01,elm\n20,1,ash\n20,3,oak\n20,1,\n")
        rows = self.predict()
        self.assertEqual([row["flag"] for row in rows], ["", "", "unknown species", "unknown zone", "missing species"])
        self.assertEqual(rows[2]["h_pred"], rows[0]["h_pred"])

    def test_species_of_new_data_are_found_whatever_their_capitals(self):
        """The study treats fir and Fir as one species; new data may have the other spelling."""
        lines = stand_csv(plots=12).splitlines()
        spelled = ["fir", "fir", "Fir"]
        rows = [line.replace(",SM,", f",{spelled[i % 3]},") for i, line in enumerate(lines[1:])]
        self.write("trees.csv", "\n".join([lines[0], *rows]) + "\n")
        self.write("settings.json", json.dumps({"responses": ["h"], "minimum_trees": 50}))
        self.run_program("study", "trees.csv", "--config", "settings.json", "--out", "study", "--quiet")
        self.write("new.csv", "plot,tree,species,dbh\n1,1,Fir,20\n1,2,FIR ,20\n1,3,oak,20\n")
        done = self.run_program("predict", "study/library.json", "new.csv")
        predicted = list(csv.DictReader(io.StringIO(done.stdout)))
        heights = [row["h_pred"] for row in predicted]
        self.assertTrue(heights[0])
        self.assertEqual(heights, [heights[0]] * 2 + [""])
        self.assertEqual([row["species"] for row in predicted], ["Fir", "FIR ", "oak"])
        self.assertIn("'Fir' as 'fir' (1 tree)", done.stderr)
        strict = self.run_program("predict", "study/library.json", "new.csv", "--case-sensitive")
        self.assertEqual([bool(row["h_pred"]) for row in csv.DictReader(io.StringIO(strict.stdout))], [False] * 3)

    def test_input_columns_stay_as_they_were(self):
        self.fit()
        self.run_program("predict", "fit.json", "new.csv", "--out", "out.csv")
        lines = (self.folder / "out.csv").read_text().splitlines()
        for before, after in zip(NEW.splitlines(), lines):
            self.assertTrue(after.startswith(before + ","), after)
        self.assertTrue(lines[0].endswith(",h_pred,flag"))

    def test_of_several_fits_the_best_predicts(self):
        self.write("stand.csv", stand_csv())
        fits = self.run_json("fit", "stand.csv", "--model", "M1", "--model", "M4")
        self.write("fits.json", json.dumps(fits))
        self.write("new.csv", NEW)
        done = self.run_program("predict", "fits.json", "new.csv")
        self.assertIn("lowest AIC", done.stderr)
        self.assertEqual(len(done.stdout.splitlines()), 6)

    def test_predictions_have_six_digits_and_more_where_they_are_asked_for(self):
        self.fit()
        whole = [row["h_pred"] for row in self.predict()]
        self.assertGreater(len(whole[0].replace(".", "")), 13)
        for options, digits in (((), 6), (("--digits", "3"), 3), (("--digits", "15"), 15)):
            done = self.run_program("predict", "fit.json", "new.csv", "--interval", "0.9", *options)
            for row, value in zip(csv.DictReader(io.StringIO(done.stdout)), whole):
                self.assertEqual(row["h_pred"], value and f"{float(value):.{digits}g}")
                self.assertLessEqual(len(row["h_lower"].replace(".", "").lstrip("-0")), digits)
        for wrong in ("0", "18", "2.5"):
            self.run_program("predict", "fit.json", "new.csv", "--digits", wrong, status=2)

    def test_large_and_small_predictions_keep_their_form(self):
        self.write("stand.csv", "x,y\n" + "".join(f"{i},{1234567.89 * i}\n" for i in range(1, 9)))
        self.write("fit.json", json.dumps(self.run_json("fit", "stand.csv", "--formula", "y ~ a*x")))
        self.write("new.csv", "x\n1\n0.0001\n0\n")
        done = self.run_program("predict", "fit.json", "new.csv")
        self.assertEqual([row["y_pred"] for row in csv.DictReader(io.StringIO(done.stdout))], ["1234570", "123.457", "0"])

    def test_json_sums_up(self):
        self.fit()
        summary = self.run_json("predict", "fit.json", "new.csv", "--out", "out.csv")
        self.assertEqual(summary["n"], 5)
        self.assertEqual(summary["predicted"], {"h": 4})
        self.assertEqual(summary["flags"], {"missing dbh": 1, "dbh outside fitted range": 1})


class Libraries(ProgramTest):
    """A study's library, put together of two fits by hand."""

    def setUp(self):
        super().setUp()
        self.write("h.csv", "dbh,h\n10,11\n20,21\n30,31\n40,43\n")
        self.write("hcb.csv", "h,hcb\n10,4\n20,9\n30,16\n45,20\n")
        h = self.run_json("fit", "h.csv", "--formula", "h ~ a + b*dbh")
        hcb = self.run_json("fit", "hcb.csv", "--formula", "hcb ~ c*h")
        self.slope = hcb["fixed"]["c"]["estimate"]
        self.library = {
            "schema": "silvafit-library/1",
            "silvafit": "0.1.0",
            "inventory": {"file": "h.csv", "fingerprint": None, "trees": 4},
            "models": [
                {"species": "SM", "response": "hcb", "unit": "m", "role": "nlme", "fit": hcb},
                {"species": "SM", "response": "h", "unit": "m", "role": "nlme", "fit": h},
            ],
        }

    def predict(self, trees, *arguments, status=0):
        self.write("library.json", json.dumps(self.library))
        self.write("new.csv", trees)
        done = self.run_program("predict", "library.json", "new.csv", "--digits", "17", *arguments, status=status)
        return done.stderr if status else list(csv.DictReader(io.StringIO(done.stdout)))

    def test_a_predicted_height_stands_in_for_a_missing_one(self):
        rows = self.predict("species,dbh,h\nSM,20,\nSM,20,25\nOF,20,25\n")
        self.assertAlmostEqual(float(rows[0]["hcb_pred"]), self.slope * float(rows[0]["h_pred"]), 10)
        self.assertEqual(rows[0]["flag"], "h predicted")
        self.assertAlmostEqual(float(rows[1]["hcb_pred"]), self.slope * 25, 10)
        self.assertEqual(rows[1]["flag"], "")
        self.assertEqual(rows[2]["hcb_pred"], "")
        self.assertIn("no model of hcb for species OF", rows[2]["flag"])

    def test_the_height_column_may_be_absent(self):
        rows = self.predict("species,dbh\nSM,20\n")
        self.assertEqual(rows[0]["flag"], "h predicted")

    def test_what_cannot_be_used_is_refused(self):
        error = self.predict("species,age\nSM,20\n", status=3)
        self.assertIn("unknown column 'dbh'", error)
        error = self.predict("dbh,h\n10,20\n", status=3)
        self.assertIn("the column 'species' is missing", error)
        error = self.predict("species,dbh,h_pred\nSM,20,1\n", status=3)
        self.assertIn("h_pred", error)
        error = self.predict("species,dbh\nSM,20\n", "--role", "ols", status=2)
        self.assertIn("no converged model with the role ols; choose one with --role: nlme", error)
        self.library["models"][0]["fit"]["sigma"] = "x"
        error = self.predict("species,dbh\nSM,20\n", status=3)
        self.assertIn("library.json: models[0].fit.sigma: must be a number", error)
        self.library["schema"] = "silvafit-library/2"
        error = self.predict("species,dbh\nSM,20\n", status=3)
        self.assertIn("library.json: schema: silvafit-library/2 was written by a newer version of silvafit", error)

    def with_crowding(self):
        """Heights of two species by models with and without C, and crown widths of one that need C."""
        self.write("h.csv", "plot,dbh,h,C,cw\n" + "".join(
            f"{1 + i % 4},{10 + i},{9 + i + 2 * (i % 3) + i % 4 + math.sin(i):.3f},{i % 3},{2 + i % 3 + math.cos(i):.3f}\n"
            for i in range(40)))
        plain = self.run_json("fit", "h.csv", "--formula", "h ~ a + b*dbh")
        crowded = self.run_json("fit", "h.csv", "--formula", "h ~ a + b*dbh + c*C")
        mixed = self.run_json("fit", "h.csv", "--formula", "h ~ a + b*dbh + c*C", "--random", "a | plot")
        wide = self.run_json("fit", "h.csv", "--formula", "cw ~ a + b*C")
        models = [{"species": species, "response": "h", "unit": "m", "role": role, "fit": fit}
                  for species in ("SM", "MH") for role, fit in (("ols", plain), ("covariates", crowded), ("nlme", mixed))]
        models.append({"species": "SM", "response": "cw", "unit": "m", "role": "nlme", "fit": wide})
        self.library["models"] = models
        return plain, crowded, mixed

    def test_where_a_column_is_missing_a_plainer_model_predicts(self):
        plain, _, _ = self.with_crowding()
        trees = "plot,tree,species,dbh\n1,1,SM,20\n1,2,MH,30\n"
        rows = self.predict(trees)
        for row in rows:
            height = plain["fixed"]["a"]["estimate"] + plain["fixed"]["b"]["estimate"] * float(row["dbh"])
            self.assertAlmostEqual(float(row["h_pred"]), height, 10)
            self.assertIn("h by the ols model: no column C", row["flag"])
        self.assertNotIn("cw_pred", rows[0])
        done = self.run_program("predict", "library.json", "new.csv", "--json")
        self.assertIn("note: column C is missing: cw is not predicted (SM); h is predicted by the ols model instead of the nlme model (SM, MH)",
                      done.stderr)
        self.assertIn("silvafit indices", done.stderr)
        summary = json.loads(done.stdout)
        self.assertEqual(summary["predicted"], {"h": 2})
        self.assertEqual(summary["unused_models"], [
            {"species": "SM", "response": "h", "model": "nlme", "missing": ["C"], "instead": "ols"},
            {"species": "MH", "response": "h", "model": "nlme", "missing": ["C"], "instead": "ols"},
            {"species": "SM", "response": "cw", "model": "nlme", "missing": ["C"], "instead": None}])
        # The calibrated level is no obstacle, though least squares knows no plots.
        self.assertEqual([row["h_pred"] for row in self.predict(trees, "--level", "calibrated")],
                         [row["h_pred"] for row in rows])
        # With the column all is as it was.
        rows = self.predict("plot,tree,species,dbh,C\n1,1,SM,20,1\n")
        self.assertEqual(rows[0]["flag"], "")
        self.assertNotEqual(rows[0]["cw_pred"], "")

    def test_a_role_that_is_asked_for_is_not_replaced(self):
        self.with_crowding()
        trees = "plot,tree,species,dbh\n1,1,SM,20\n"
        error = self.predict(trees, "--role", "nlme", status=3)
        self.assertIn("unknown column 'C'", error)
        self.assertIn("The models of --role ols do not need it", error)
        self.assertNotEqual(self.predict(trees, "--role", "ols")[0]["h_pred"], "")

    def test_a_model_whose_column_is_missing_does_not_stop_the_others(self):
        rows = self.predict("species,h\nSM,20\n")
        self.assertAlmostEqual(float(rows[0]["hcb_pred"]), self.slope * 20, 10)
        self.assertNotIn("h_pred", rows[0])
        # Neither h nor what it is predicted from: what needs h falls away with it.
        self.write("cw.csv", "age,cw\n10,2\n20,3\n30,5\n40,6\n")
        wide = self.run_json("fit", "cw.csv", "--formula", "cw ~ a + b*age")
        self.library["models"].append({"species": "SM", "response": "cw", "unit": "m", "role": "nlme", "fit": wide})
        rows = self.predict("species,age\nSM,20\n")
        self.assertEqual(list(rows[0]), ["species", "age", "cw_pred", "flag"])
        # A species may lack what another one has.
        self.library["models"].append({"species": "OF", "response": "h", "unit": "m", "role": "nlme",
                                       "fit": self.run_json("fit", "h.csv", "--formula", "h ~ a + b*dbh^c")})
        self.library["models"][0]["species"] = "OF"
        rows = self.predict("species,h\nSM,20\nOF,20\n")
        self.assertEqual([row["hcb_pred"] == "" for row in rows], [True, False])

    def test_of_several_fits_the_best_that_has_its_columns_predicts(self):
        _, crowded, _ = self.with_crowding()
        plain = self.library["models"][0]["fit"]
        self.write("fits.json", json.dumps({"fits": [crowded, plain]}))
        self.write("new.csv", "dbh\n20\n")
        done = self.run_program("predict", "fits.json", "new.csv", "--digits", "17")
        self.write("plain.json", json.dumps(plain))
        alone = self.run_program("predict", "plain.json", "new.csv", "--digits", "17")
        self.assertEqual([row["h_pred"] for row in csv.DictReader(io.StringIO(done.stdout))],
                         [row["h_pred"] for row in csv.DictReader(io.StringIO(alone.stdout))])
        self.assertIn("column C is missing", done.stderr)

    def test_indices_are_computed_as_in_the_study(self):
        trees = str(EXAMPLES / "fir-mixed" / "inventory.csv")
        self.run_program("study", trees, "--species", "SM,BHN", "--responses", "cw", "--per", "stand", "--neighbors", "6",
                         "--dominance", "h", "--alpha", "60", "--quiet", "--out", "study")
        indices = "W=W,M=M,U=U,C=C"

        def crown_widths(library):
            done = self.run_program("predict", library, trees, "--columns", indices, "--digits", "17")
            self.assertIn("from the 6 nearest trees of the stand" if library.startswith("study/") else
                          "from the 4 nearest trees of each plot", done.stderr)
            return {(row["plot"], row["tree"]): row["cw_pred"] for row in csv.DictReader(io.StringIO(done.stdout))
                    if row["species"] in ("SM", "BHN")}

        with open(self.folder / "study" / "predictions.csv", newline="", encoding="utf-8") as file:
            expected = {(row["plot"], row["tree"]): row["cw_population"] for row in csv.DictReader(file) if row["cw_population"]}
        self.assertGreater(len(expected), 2000)
        predicted = crown_widths("study/library.json")
        self.assertEqual({tree: predicted[tree] for tree in expected}, expected)
        # The settings matter: a library that does not say them gives other crown widths.
        library = json.loads((self.folder / "study" / "library.json").read_text(encoding="utf-8"))
        del library["inventory"]["structural_units"]
        self.write("silent.json", json.dumps(library))
        others = crown_widths("silent.json")
        self.assertGreater(sum(others[tree] != value for tree, value in expected.items()), 1000)

    def test_published_models_say_what_intervals_and_means_over_plots_lack(self):
        self.write("new.csv", "plot,species,dbh,h,C,M,U\nA,BHN,20,,0.5,0.5,0.5\n")
        for options, missing in ((("--interval", "0.9"), "no h interval: variances unknown"),
                                 (("--level", "marginal"), "no marginal h: the covariance matrix of the random effects is unknown")):
            done = self.run_program("predict", "shanxia-2023", "new.csv", *options)
            flag = list(csv.DictReader(io.StringIO(done.stdout)))[0]["flag"]
            self.assertIn(missing, flag)
            self.assertNotIn("interval includes", flag)

    def test_a_height_of_0_does_not_calibrate(self):
        self.write("trees.csv", stand_csv())
        fit = self.run_program("fit", "trees.csv", "--model", "M4", "--random", "a | plot", "--json").stdout
        self.write("fit.json", fit)
        self.write("zero.csv", "plot,dbh,h\nnew,20,18\nnew,22,0\n")
        done = self.run_program("predict", "fit.json", "zero.csv", "--level", "calibrated")
        self.assertIn("note: codes read as missing values: h 1 (0)", done.stderr)
        self.assertEqual([row["h_trees"] for row in csv.DictReader(io.StringIO(done.stdout))], ["1", "1"])
        self.write("text.csv", "plot,dbh,h\nnew,20,tall\n")
        error = self.run_program("predict", "fit.json", "text.csv", "--level", "calibrated", status=3).stderr
        self.assertIn("text.csv:2: h: 'tall' is not a number", error)

    def test_published_models_say_what_calibration_lacks(self):
        self.write("new.csv", "plot,species,dbh,h,C,M,U\nA,SM,20,15,0.5,0.5,0.5\n")
        done = self.run_program("predict", "shanxia-2023", "new.csv", "--role", "nlme", "--level",
                                "calibrated", status=2)
        self.assertIn("which the publication does not give", done.stderr)


if __name__ == "__main__":
    unittest.main()
