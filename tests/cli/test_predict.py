# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit predict`."""

import csv
import io
import json
import math
import unittest

from silvafit_program import ProgramTest, stand_csv

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
        output = self.run_program("predict", "fit.json", "new.csv", *arguments).stdout
        return list(csv.DictReader(io.StringIO(output)))

    def height(self, fit, dbh, plot=None):
        a = fit["fixed"]["a"]["estimate"] + (fit["random"]["eblup"][plot]["a"] if plot else 0.0)
        return 1.3 + a * (1 - math.exp(-fit["fixed"]["b"]["estimate"] * dbh))

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
        self.assertEqual(rows[2]["h_pred"], "")
        error = self.run_program("predict", "fit.json", "new.csv", "--level", "conditional",
                                 "--new-groups", "error", status=3).stderr
        self.assertIn("new.csv:", error)
        self.assertIn("is no group of the fit", error)

    def test_gaps_and_extrapolation_are_flagged(self):
        self.fit()
        rows = self.predict()
        self.assertEqual((rows[3]["h_pred"], rows[3]["flag"]), ("", "missing dbh"))
        self.assertEqual(rows[4]["flag"], "dbh outside fitted range")

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
        done = self.run_program("predict", "library.json", "new.csv", *arguments, status=status)
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
        error = self.predict("species,h\nSM,20\n", status=3)
        self.assertIn("there is no column 'dbh'", error)
        error = self.predict("dbh,h\n10,20\n", status=3)
        self.assertIn("there is no column 'species'", error)
        error = self.predict("species,dbh,h_pred\nSM,20,1\n", status=3)
        self.assertIn("h_pred", error)
        error = self.predict("species,dbh\nSM,20\n", "--role", "ols", status=2)
        self.assertIn("no model of the role ols; it has nlme", error)
        self.library["models"][0]["fit"]["sigma"] = "x"
        error = self.predict("species,dbh\nSM,20\n", status=3)
        self.assertIn("library.json: models[0].fit.sigma: must be a number", error)
        self.library["schema"] = "silvafit-library/2"
        error = self.predict("species,dbh\nSM,20\n", status=3)
        self.assertIn("library.json: schema: silvafit-library/2 is from a newer silvafit", error)


if __name__ == "__main__":
    unittest.main()
