# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit fit --bootstrap`, `--cross-validate` and `--residuals`."""

import csv
import json
import math
import unittest

from silvafit_program import ProgramTest, stand_csv

MEYER = "h ~ 1.3 + a*(1 - exp(-b*dbh))"
MIXED = ("fit", "stand.csv", "--formula", MEYER, "--random", "a | plot")


class Bootstrap(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("stand.csv", stand_csv())

    def test_every_parameter_has_its_figures(self):
        fit = self.run_json(*MIXED, "--bootstrap", "40", "--variance", "power")
        bootstrap = fit["bootstrap"]
        self.assertEqual(bootstrap["resample"], "parametric")
        self.assertEqual(bootstrap["replicates"], 40)
        failed = sum(one["replicates"] for one in bootstrap["failures"])
        self.assertEqual(bootstrap["converged"] + failed, 40)
        self.assertEqual(list(bootstrap["parameters"]), ["a", "b", "sd(a)", "delta", "sigma"])
        a = bootstrap["parameters"]["a"]
        self.assertEqual(a["estimate"], fit["fixed"]["a"]["estimate"])
        # A bootstrap's standard error from 40 replicates is within a factor of 2 of Wald's.
        self.assertLess(abs(math.log(a["se"] / fit["fixed"]["a"]["se"])), math.log(2))
        self.assertLess(a["percentile"][0], a["percentile"][1])
        self.assertAlmostEqual(a["basic"][0], 2 * a["estimate"] - a["percentile"][1], 12)

    def test_quantiles_beyond_the_replicates_are_missing(self):
        # A quantile of 0.1 of R values is at (R + 1) 0.1, which is the first of 9.
        few, enough = (self.run_json(*MIXED, "--bootstrap", number, "--bootstrap-level", "0.8")["bootstrap"] for number in ("8", "9"))
        self.assertEqual((few["converged"], enough["converged"]), (8, 9))
        self.assertEqual(few["parameters"]["a"]["percentile"], [None, None])
        self.assertNotIn(None, enough["parameters"]["a"]["percentile"])
        text = self.run_program(*MIXED, "--bootstrap", "8").stdout
        self.assertIn("Intervals of 95 % need at least 39 replicates.", text)

    def test_threads_do_not_change_a_byte_and_seeds_do(self):
        arguments = (*MIXED, "--bootstrap", "10", "--resample", "cases", "--json")
        def figures(*more):
            text = self.run_program(*arguments, *more).stdout
            return text[text.index('"bootstrap"'):]
        one = figures("--seed", "5", "--threads", "1")
        self.assertEqual(one, figures("--seed", "5", "--threads", "2"))
        self.assertNotEqual(one, figures("--seed", "6"))

    def test_people_get_a_table(self):
        text = self.run_program(*MIXED, "--bootstrap", "10").stdout
        self.assertRegex(text, r"parametric bootstrap, seed 1: \d+ of 10 replicates converged")
        self.assertRegex(text, r"(?m)^sd\(a\) ")

    def test_what_is_drawn_can_be_named(self):
        cases = (*MIXED, "--bootstrap", "10", "--resample", "cases", "--json")
        def figures(*more):
            return json.loads(self.run_program(*cases, *more).stdout)["bootstrap"]["parameters"]
        self.assertEqual(figures("--group", "plot"), figures())
        error = self.run_program(*cases, "--group", "nosuch", status=2).stderr
        self.assertIn("unknown column 'nosuch'", error)
        error = self.run_program(*cases, "--group", "dbh", status=2).stderr
        self.assertIn("name a coarser grouping", error)
        error = self.run_program(*MIXED, "--bootstrap", "10", "--group", "plot", status=2).stderr
        self.assertIn("--resample cases", error)

    def test_a_level_outside_its_range_is_refused(self):
        done = self.run_program(*MIXED, "--bootstrap", "10", "--bootstrap-level", "95", status=2)
        self.assertIn("between 0 and 1", done.stderr)


class CrossValidation(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("stand.csv", stand_csv())

    def test_each_group_is_left_out(self):
        fit = self.run_json(*MIXED, "--cross-validate", "leave-one-out", "--measured-trees", "3")
        result = fit["cross_validation"]
        self.assertEqual((result["group"], result["groups"], result["folds"]), ("plot", 6, 6))
        self.assertEqual(result["predicted"], 120)
        self.assertEqual(result["failed"], [])
        calibrated = result["calibrated"]
        self.assertEqual((calibrated["measured"], calibrated["predicted"]), (3, 120 - 6 * 3))
        # Plots differ by 2 m and trees by 0.5 m: three trees tell most of it.
        self.assertLess(calibrated["statistics"]["rmse"], calibrated["population"]["rmse"])

    def test_least_squares_needs_a_column_of_groups(self):
        line = ("fit", "stand.csv", "--formula", MEYER, "--cross-validate", "3")
        self.assertIn("name their column", self.run_program(*line, status=2).stderr)
        result = self.run_json(*line, "--group", "plot")["cross_validation"]
        self.assertEqual((result["folds"], result["calibrated"]), (3, None))

    def test_folds_are_a_number_or_leave_one_out(self):
        done = self.run_program(*MIXED, "--cross-validate", "all", status=2)
        self.assertIn("leave-one-out", done.stderr)


class Residuals(ProgramTest):
    def test_every_row_has_its_line(self):
        lines = stand_csv().splitlines()
        fields = lines[3].split(",")
        lines[3] = ",".join([*fields[:4], "", fields[5]])
        self.write("stand.csv", "\n".join(lines) + "\n")
        fit = self.run_json(*MIXED, "--residuals", "residuals.csv")
        with open(self.folder / "residuals.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([int(row["line"]) for row in rows], list(range(2, 122)))
        self.assertEqual(rows[2]["observed"], "")
        used = [row for row in rows if row["observed"]]
        self.assertEqual(len(used), fit["n"])
        self.assertEqual(used[0]["group"], "01")
        for row in used:
            raw = float(row["observed"]) - float(row["fitted_conditional"])
            self.assertAlmostEqual(float(row["residual_conditional"]), raw, 12)
            self.assertAlmostEqual(float(row["standardized_conditional"]), raw / fit["sigma"], 10)
            self.assertEqual(row["normalized"], row["standardized_conditional"])
        # At the maximum over sigma the squares of the marginal residuals sum to n.
        squares = sum(float(row["marginal"]) ** 2 for row in used)
        self.assertAlmostEqual(squares / fit["n"], 1.0, 5)

    def test_shares_of_variance_are_between_0_and_1(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json(*MIXED)
        self.assertLess(0, fit["r2_marginal"])
        self.assertLess(fit["r2_marginal"], fit["r2_conditional"])
        self.assertLess(fit["r2_conditional"], 1)
        plain = self.run_json("fit", "stand.csv", "--formula", MEYER)
        self.assertIsNone(plain["r2_marginal"])


if __name__ == "__main__":
    unittest.main()
