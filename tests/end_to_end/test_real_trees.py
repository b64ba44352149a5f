# SPDX-License-Identifier: MIT
"""Studies and fits of measured pines agree with R's nls and nlme on the same trees."""

import json
import unittest
from pathlib import Path

from silvafit_program import ProgramTest
from study_folder import StudyFolder, read_csv, run_node

REFERENCE = Path(__file__).resolve().parents[1] / "reference"
SPATI = ("--columns", "tree=puunro,species=pl,x=xk/10,y=yk/10,dbh=d")
ALS = ("--columns", "dbh=DBH,h=H,hcb=HCB")
# R's name of a model and the catalogue's.
SPATI_MODELS = {"naslund": "M1", "curtis": "M2", "korf": "M14", "richards": "M8"}
FUNCTIONS = {"none": "none", "varExp": "exponential", "varPower": "power",
             "varConstPower": "constant-plus-power"}


def log_likelihoods():
    fits = json.loads((REFERENCE / "expected/public_nlme.json").read_text(encoding="utf-8"))["fits"]
    return {fit["id"]: fit["logLik"] for fit in fits}


class RealTrees(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.reference = log_likelihoods()
        cls.spati = str(REFERENCE / "data-gpl/spati.csv")
        cls.als = str(REFERENCE / "data-gpl/alsTree.csv")

    def study(self, inventory, *arguments):
        self.run_program("study", inventory, "--out", "out", *arguments)
        opened = run_node("SILVAFIT_CHECK_REPORT", self.folder / "out" / "report.html")
        self.assertEqual(opened.returncode, 0, opened.stderr)
        return StudyFolder(self.folder / "out")

    def candidate(self, folder, response, model):
        return next(row for row in folder.tables["candidates"]
                    if row["response"] == response and row["model"] == model)

    def test_spati_base_models_are_those_of_nls_on_the_same_trees(self):
        folder = self.study(self.spati, *SPATI)
        # The study leaves out the edge of each plot; the same trees by hand are its core with h.
        for name, model in SPATI_MODELS.items():
            every = self.run_json("fit", self.spati, "--columns", "dbh=d", "--model", model)
            self.assertEqual(every["n"], 1678)
            self.assertAlmostEqual(every["log_likelihood"], self.reference[f"spati_{name}_nls"], 6)
            core = self.run_json("fit", "out/predictions.csv", "--model", model, "--where",
                                 "core == 1 && W >= 0 && U >= 0")
            row = self.candidate(folder, "h", model)
            self.assertAlmostEqual(float(row["log_likelihood"]), core["log_likelihood"], 6)
        self.assertEqual(folder.report["inventory"]["species"][0]["code"], "1")
        self.assertIn("M is 0", " ".join(folder.report["results"][0]["notes"]))
        self.assertEqual(len(folder.predictions) + len(folder.excluded),
                         len(read_csv(self.spati)))
        self.assertTrue(all(row["h_ols"] for row in folder.predictions))

    def reached(self, name, model, function):
        """The log-likelihood, which is nlme's or higher: nlme's constant-plus-power of Curtis and
        Korf stopped below the power variance that it contains."""
        fit = self.run_json("fit", self.spati, "--columns", "dbh=d", "--model", model,
                            "--random", "a + b | plot", "--variance", FUNCTIONS[function])
        self.assertTrue(fit["converged"], fit["verdict"])
        self.assertGreaterEqual(fit["log_likelihood"],
                                self.reference[f"spati_{name}_{function}"] - 1e-3)
        return fit["log_likelihood"]

    def test_spati_mixed_models_reach_what_nlme_reaches(self):
        for name, model in SPATI_MODELS.items():
            with self.subTest(model=name):
                constant = self.reached(name, model, "none")
                power = self.reached(name, model, "varPower")
                both = self.reached(name, model, "varConstPower")
                self.assertGreater(power, constant)
                # Two linearizations at nearly the same point differ by a few 1e-6.
                self.assertGreaterEqual(both, power - 1e-4)

    def test_als_study_has_no_level_2_and_agrees_with_nls_and_nlme(self):
        folder = self.study(self.als, *ALS)
        self.assertEqual(folder.tables["covariates"], [])
        notes = " ".join(folder.report["notes"])
        self.assertIn("level 2 was skipped", notes)
        self.assertIn("no column species", notes)
        walters = self.candidate(folder, "hcb", "M17")
        self.assertAlmostEqual(float(walters["log_likelihood"]),
                               self.reference["alsTree_walters_nls"], 6)
        self.assertEqual(walters["chosen"], "yes")
        mixed = next(row for row in folder.tables["random_effects"]
                     if row["response"] == "hcb" and row["random_effects"] == "a + b")
        self.assertAlmostEqual(float(mixed["log_likelihood"]),
                               self.reference["alsTree_walters_none"], 5)

    def test_als_mixed_models_reach_what_nlme_reaches(self):
        for name, model, functions in (
                ("walters", "M17", ("none", "varExp", "varPower", "varConstPower")),
                ("naslund", "M1", ("none", "varPower"))):
            for function in functions:
                with self.subTest(model=name, variance=function):
                    # R's fits of height used the trees with a crown base too.
                    fit = self.run_json("fit", self.als, *ALS, "--model", model, "--where",
                                        "HCB >= 0", "--random", "a + b | plot", "--variance",
                                        FUNCTIONS[function])
                    self.assertEqual(fit["n"], 1497)
                    self.assertTrue(fit["converged"], fit["verdict"])
                    self.assertGreaterEqual(fit["log_likelihood"],
                                            self.reference[f"alsTree_{name}_{function}"] - 1e-3)


if __name__ == "__main__":
    unittest.main()
