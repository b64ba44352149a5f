# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit compare` and `silvafit fit --intervals`."""

import json
import math
import random
import unittest

from silvafit_program import ProgramTest


def lines(spread, seed=5):
    """Straight lines whose intercepts differ by plot."""
    draw = random.Random(seed)
    rows = ["plot,x,y"]
    for plot in range(10):
        effect = draw.gauss(0, spread)
        rows += [f"p{plot},{x},{10 + effect + 2 * x + draw.gauss(0, 1):.6f}" for x in range(-3, 4)]
    return "\n".join(rows) + "\n"


class Compare(ProgramTest):
    def save(self, name, *arguments):
        text = self.run_program("fit", "lines.csv", "--formula", "y ~ a + b*x", *arguments, "--json").stdout
        self.write(name, text)
        return json.loads(text)

    def test_a_variance_is_tested_by_half_and_half(self):
        self.write("lines.csv", lines(0.6))
        none = self.save("none.json")
        one = self.save("one.json", "--random", "a | plot")
        comparison = self.run_json("compare", "one.json", "none.json")
        self.assertEqual(comparison["schema"], "silvafit-compare/1")
        result = comparison["comparisons"][0]
        self.assertEqual([fit["name"] for fit in result["fits"]], ["none.json", "one.json"])
        test = result["tests"][0]
        statistic = 2 * (one["log_likelihood"] - none["log_likelihood"])
        self.assertAlmostEqual(test["statistic"], statistic, 10)
        # One degree of freedom: the tail is erfc(sqrt(x / 2)).
        self.assertAlmostEqual(test["p_chi_squared"], math.erfc(math.sqrt(statistic / 2)), 12)
        self.assertAlmostEqual(test["p"], test["p_chi_squared"] / 2, 12)
        self.assertEqual(test["reference"], "1/2 chi-squared(0) + 1/2 chi-squared(1)")
        weights = [math.exp(-fit["aic_difference"] / 2) for fit in result["fits"]]
        for fit, weight in zip(result["fits"], weights):
            self.assertAlmostEqual(fit["akaike_weight"], weight / sum(weights), 12)
        self.assertAlmostEqual(one["bic_groups"], -2 * one["log_likelihood"] + 4 * math.log(10), 9)
        text = self.run_program("compare", "one.json", "none.json").stdout
        self.assertIn("1/2 chi-squared(0)", text)

    def test_other_data_are_not_compared(self):
        self.write("lines.csv", lines(0.6))
        self.save("one.json", "--random", "a | plot")
        self.write("lines.csv", lines(0.6, seed=6))
        self.save("none.json")
        result = self.run_json("compare", "one.json", "none.json")["comparisons"][0]
        self.assertIn("different observations", result["why_not_comparable"])
        self.assertIn("different observations", result["tests"][0]["why_not"])
        self.assertIsNone(result["fits"][0]["akaike_weight"])

    def test_one_fit_alone_is_no_comparison(self):
        self.write("lines.csv", lines(0.6))
        self.save("one.json")
        self.run_program("compare", "one.json", status=2)
        self.save("two.json", "--random", "a | plot")
        self.write("log.json", self.run_program("fit", "lines.csv", "--formula", "log(y) ~ a + b*x", "--json").stdout)
        said = self.run_program("compare", "one.json", "two.json", "log.json").stderr
        self.assertIn("note: log.json is not compared: it is the only fit for log(y)", said)

    def test_equal_likelihoods_are_no_evidence(self):
        # Without any variance between the plots the ratio is 0 but for rounding, which is as likely as all values.
        rows = ["plot,x,y"] + [f"p{plot},{x},{10 + 2 * x + (1 if (x + plot) % 2 else -1)}" for plot in range(6) for x in range(8)]
        self.write("lines.csv", "\n".join(rows) + "\n")
        self.save("none.json")
        self.save("one.json", "--random", "a | plot")
        test = self.run_json("compare", "one.json", "none.json")["comparisons"][0]["tests"][0]
        self.assertEqual((test["statistic"], test["p"]), (0, 1))


class Intervals(ProgramTest):
    def test_both_kinds_hold_the_estimates(self):
        self.write("lines.csv", lines(2.0))
        for kind in ("wald", "profile"):
            fit = self.run_json("fit", "lines.csv", "--formula", "y ~ a + b*x", "--random", "a | plot",
                                "--intervals", kind, "--level", "0.9")
            intervals = fit["intervals"]
            self.assertEqual((intervals["method"], intervals["level"]), (kind, 0.9))
            self.assertEqual(list(intervals["parameters"]), ["a", "b", "sd(a)", "sigma"])
            for one in intervals["parameters"].values():
                self.assertLess(one["lower"], one["estimate"])
                self.assertLess(one["estimate"], one["upper"])

    def test_effects_have_conditional_standard_errors(self):
        self.write("lines.csv", lines(2.0))
        fit = self.run_json("fit", "lines.csv", "--formula", "y ~ a + b*x", "--random", "a | plot")
        # Balanced one-way layout: Var(b | y) = 1 / (n / sigma^2 + 1 / tau^2).
        expected = 1 / math.sqrt(7 / fit["sigma"] ** 2 + 1 / fit["random"][0]["sd"][0] ** 2)
        for group in fit["random"][0]["eblup_se"].values():
            self.assertAlmostEqual(group["a"] / expected, 1.0, 8)

    def test_a_wrong_level_is_a_mistake_in_usage(self):
        self.write("lines.csv", lines(2.0))
        self.run_program("fit", "lines.csv", "--formula", "y ~ a + b*x", "--intervals", "wald", "--level", "95",
                         status=2)


if __name__ == "__main__":
    unittest.main()
