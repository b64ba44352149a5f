# SPDX-License-Identifier: MIT
"""The files of a study exist, mean what they say, and agree with each other."""

import csv
import json
import math
import shutil
import subprocess
import tempfile
import unittest

from silvafit_program import PROGRAM
from study_folder import EXAMPLE, PREDICTIONS, TABLES, StudyFolder, read_csv, statistics_of

RESPONSES = ("h", "hcb", "cw")
UNITS = ("--window", str(EXAMPLE / "window.geojson"), "--per", "stand")


def run(folder, *arguments):
    return subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True,
                          timeout=120, check=True)


def study(folder, out, *arguments):
    return run(folder, "study", str(EXAMPLE / "inventory.csv"), "--out", out, "--species", "SM",
               "--responses", ",".join(RESPONSES), *UNITS, *arguments)


class StudyFiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="silvafit-study-")
        cls.addClassCleanup(temporary.cleanup)
        cls.place = temporary.name
        cls.done = study(cls.place, "study", "--threads", "1")
        cls.folder = StudyFolder(f"{cls.place}/study")

    def assert_close(self, actual, expected, digits=1e-9):
        self.assertTrue(math.isclose(float(actual), expected, rel_tol=digits, abs_tol=digits),
                        f"{actual} is not {expected}")

    def test_all_files_of_the_contract_are_there(self):
        wanted = {"library.json", "indices.csv", "predictions.csv", "excluded.csv", "report.html",
                  "run.json"} | {f"tables/{name}.{kind}" for name in TABLES
                                    for kind in ("csv", "md", "tex")}
        self.assertEqual(set(self.folder.files()), wanted)

    def test_run_says_what_was_done(self):
        run_record = self.folder.run
        self.assertEqual(run_record["fits"], sum(stage["fits"] for stage in run_record["stages"]))
        rows = sum(len(self.folder.tables[name])
                   for name in ("candidates", "covariates", "random_effects", "variance_functions"))
        # The chosen random effects with a constant variance are rows of two tables, and one fit.
        rows -= sum(row["function"] == "none" for row in self.folder.tables["variance_functions"])
        # Three levels are fitted again for each fold of plots left out.
        left_out = sum(3 * int(row["folds"]) for row in self.folder.tables["plots_left_out"])
        self.assertEqual(run_record["fits"], rows + left_out)
        self.assertTrue(all(stage["seconds"] >= 0 for stage in run_record["stages"]))
        self.assertIn("--window", run_record["command"])
        self.assertEqual(run_record["input"]["fingerprint"],
                         self.folder.library["inventory"]["fingerprint"])

    def test_soundness_is_the_same_everywhere(self):
        results = self.folder.run["results"]
        self.assertEqual([result["sound"] for result in results],
                         [result["sound"] for result in self.folder.report["results"]])
        sound = sum(result["sound"] for result in results)
        self.assertTrue(self.done.stdout.startswith(f"Sound: {sound} of {len(results)} final models.\n"))
        for result in results:
            self.assertEqual(result["sound"], result["converged"] and not result["doubts"])
            worse = bool(result["left_out"]) and result["left_out"]["worse"]
            self.assertEqual(worse, any("plots left out" in doubt for doubt in result["doubts"]))

    def test_gains_follow_from_the_statistics(self):
        statistics = {(row["response"], row["level"], row["prediction"]): row
                      for row in self.folder.tables["statistics"]}
        for row in self.folder.tables["gains"]:
            ols = statistics[row["response"], "ols", "population"]
            nlme = statistics[row["response"], "nlme", "conditional"]
            self.assert_close(row["gain"], 100 * (float(nlme["r2"]) - float(ols["r2"])))
            self.assert_close(row["rmse_reduction"],
                              100 * (1 - float(nlme["rmse"]) / float(ols["rmse"])))
            self.assert_close(row["aic_nlme"], float(nlme["aic"]))

    def test_tests_of_the_levels_follow_from_the_statistics(self):
        likelihood = {(row["response"], row["level"]): float(row["log_likelihood"])
                      for row in self.folder.tables["statistics"]}
        before = {"covariates": "ols", "nlme": "covariates"}
        for row in self.folder.tables["level_tests"]:
            key = row["response"], row["level"]
            self.assert_close(row["log_likelihood"], likelihood[key])
            if row["likelihood_ratio"]:
                smaller = likelihood[row["response"], before[row["level"]]]
                self.assert_close(row["likelihood_ratio"], 2 * (likelihood[key] - smaller))

    def test_importance_values_add_up(self):
        for column in ("relative_density", "relative_frequency", "relative_dominance",
                       "importance"):
            total = sum(float(row[column]) for row in self.folder.tables["species"])
            self.assert_close(total, 100.0)

    def test_coefficients_stand_in_one_row_a_model(self):
        fits = self.folder.fits()
        titles = {"ols": "OLS", "covariates": "OLS, covariates", "nlme": "NLME"}
        rows = {(row["response"], row["model"]): row for row in self.folder.tables["coefficients"]}
        for (_, response, role), fit in fits.items():
            if role == "covariates" and fit["fixed"].keys() == fits["SM", response, "ols"]["fixed"].keys():
                self.assertNotIn((response, titles[role]), rows)
                continue
            row = rows[response, titles[role]]
            self.assert_close(row["aic"], fit["aic"])
            for name, value in fit["fixed"].items():
                parameter, _, covariate = name.partition(":")
                cell = row[covariate or parameter]
                if covariate:
                    before, cell = cell.split(": ")
                    self.assertEqual(before, parameter)
                stars = (value["p"] < 0.05) + (value["p"] < 0.01) + (value["p"] < 0.001)
                self.assertEqual(cell.count("*"), stars)
                # Five significant digits are written.
                self.assert_close(cell.rstrip("*"), value["estimate"], 1e-4)

    def test_variances_and_accuracy_stand_in_one_row_a_model(self):
        for row in self.folder.tables["variance_and_fit"]:
            role = {"OLS": "ols", "OLS, covariates": "covariates", "NLME": "nlme"}[row["model"]]
            fit = self.folder.fits()["SM", row["response"], role]
            self.assert_close(row["sigma2"], fit["sigma"] ** 2)
            statistics = fit["statistics"]
            self.assert_close(row["r2"], (statistics["conditional"] or statistics["population"])["r2"])
            left_out = self.folder.table("plots_left_out", "SM", row["response"])[0]
            self.assert_close(row["r2_left_out"], float(left_out[f"r2_{role}"]))
            if role == "nlme":
                effects = row["random_effects"].split(", ")
                self.assertEqual(effects, fit["random"][0]["effects"])
                for place, sd in enumerate(fit["random"][0]["sd"], 1):
                    self.assert_close(row[f"psi2_{place}"], sd ** 2)

    def test_random_effects_of_each_plot_are_a_table(self):
        for row in self.folder.tables["plot_effects"]:
            random = self.folder.fits()["SM", row["response"], "nlme"]["random"][0]
            self.assert_close(row["eblup"], random["eblup"][row["plot"]][row["effect"]])
        names = {(row["response"], row["plot"]) for row in self.folder.tables["plot_effects"]
                 if float(row["p"] or 1) < 0.05}
        reported = {(result["response"], plot["plot"]) for result in self.folder.report["results"]
                    for plot in result["outlying"]}
        self.assertEqual(names, reported)
        # Trees of plot 2 of the example are lower than others of their DBH.
        self.assertIn(("h", "2"), names)

    @unittest.skipUnless(shutil.which("pdflatex"), "no pdflatex (Debian: texlive-latex-base)")
    def test_latex_tables_compile_and_fit_the_page(self):
        for name in TABLES:
            text = ("\\documentclass{article}\\usepackage[a4paper,margin=2cm]{geometry}\\usepackage{graphicx}"
                    f"\\begin{{document}}\\input{{{self.place}/study/tables/{name}.tex}}\\end{{document}}")
            done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error",
                                   f"-jobname={name}", f"-output-directory={self.place}", text],
                                  cwd=self.place, capture_output=True, text=True, timeout=60,
                                  check=False)
            self.assertEqual(done.returncode, 0, f"{name}: {done.stdout[-2000:]}")
            self.assertNotIn("Overfull \\hbox", done.stdout, name)

    def test_stdout_names_the_report_and_stderr_is_for_messages(self):
        self.assertIn("study/report.html", self.done.stdout)
        for response in RESPONSES:
            self.assertIn(f" {response} ", self.done.stdout)
        self.assertNotIn("R2", self.done.stderr)

    def test_json_is_all_of_stdout(self):
        done = study(self.place, "again", "--json", "--quiet")
        summary = json.loads(done.stdout)
        self.assertEqual(done.stderr, "")
        self.assertEqual([row["response"] for row in summary["results"]], list(RESPONSES))
        for row in summary["results"]:
            fits = self.folder.fits()
            nlme = fits[("SM", row["response"], "nlme")]
            self.assertEqual(row["r2_nlme"], nlme["statistics"]["conditional"]["r2"])
            self.assertEqual(row["n"], nlme["n"])

    def test_threads_change_no_byte(self):
        study(self.place, "threads/study", "--threads", "2")
        other = StudyFolder(f"{self.place}/threads/study")
        files = self.folder.files()
        others = other.files()
        self.assertEqual(set(files), set(others))
        for name in set(files) - {"run.json", "report.html"}:
            self.assertEqual(files[name], others[name], name)
        report, other_report = self.folder.report, other.report
        self.assertNotEqual(report.pop("command"), other_report.pop("command"))
        self.assertEqual(report, other_report)

    def test_indices_are_those_of_the_command_indices(self):
        run(self.place, "indices", str(EXAMPLE / "inventory.csv"), "--out", "indices.csv", *UNITS)
        with open(f"{self.place}/indices.csv", "rb") as file:
            self.assertEqual(file.read(), self.folder.files()["indices.csv"])

    def test_predictions_carry_the_inventory_and_the_indices(self):
        inventory = read_csv(EXAMPLE / "inventory.csv")
        indices = read_csv(self.folder.folder / "indices.csv")
        self.assertEqual(len(self.folder.predictions), len(inventory))
        for row, tree, unit in zip(self.folder.predictions, inventory, indices):
            for name in ("plot", "tree", "species"):
                self.assertEqual(row[name], tree[name])
            for name in ("x", "y", "dbh", "h", "hcb", "cw"):
                self.assertEqual(float(row[name]), float(tree[name]))
            for name in ("core", "W", "M", "U", "C"):
                self.assertEqual(row[name], unit[name])

    def test_statistics_are_those_of_the_predictions(self):
        for response in RESPONSES:
            for row in self.folder.table("statistics", "SM", response):
                column = PREDICTIONS.get((row["level"], row["prediction"]))
                if column is None:
                    continue
                with self.subTest(response=response, prediction=column):
                    pairs = self.folder.pairs("SM", response, column)
                    self.assertEqual(int(row["n"]), len(pairs))
                    for name, value in statistics_of(pairs).items():
                        self.assert_close(row[name], value)

    def test_criteria_follow_from_likelihood_and_parameters(self):
        trees = {response: self.folder.fits()[("SM", response, "ols")]["n"]
                 for response in RESPONSES}
        for name in ("candidates", "covariates", "random_effects", "variance_functions",
                     "statistics"):
            for row in self.folder.tables[name]:
                if not row["log_likelihood"]:
                    continue
                deviance = -2 * float(row["log_likelihood"])
                self.assert_close(row["aic"], deviance + 2 * int(row["k"]))
                self.assert_close(row["bic"],
                                  deviance + int(row["k"]) * math.log(trees[row["response"]]))

    def test_tables_hold_what_the_library_holds(self):
        for (species, response, role), fit in self.folder.fits().items():
            rows = [row for row in self.folder.table("statistics", species, response)
                    if row["level"] == role]
            for row in rows:
                self.assertEqual(float(row["log_likelihood"]), fit["log_likelihood"])
                self.assertEqual(float(row["r2"]), fit["statistics"][row["prediction"]]["r2"])
            estimates = {row["coefficient"]: row
                         for row in self.folder.table("estimates", species, response)
                         if row["level"] == role}
            self.assertEqual(set(estimates), set(fit["fixed"]))
            for name, coefficient in fit["fixed"].items():
                self.assertEqual(float(estimates[name]["estimate"]), coefficient["estimate"])
                self.assertEqual(float(estimates[name]["se"]), coefficient["se"])
                self.assert_close(estimates[name]["t"],
                                  coefficient["estimate"] / coefficient["se"])
            if role != "nlme":
                continue
            components = {row["component"]: float(row["value"])
                          for row in self.folder.table("variance_components", species, response)}
            self.assertEqual(components["sigma"], fit["sigma"])
            for name, deviation in zip(fit["random"][0]["effects"], fit["random"][0]["sd"]):
                self.assertEqual(components[f"sd({name})"], deviation)

    def test_one_row_of_each_level_is_chosen_and_is_the_model_of_the_library(self):
        levels = {"candidates": "ols", "covariates": "covariates", "variance_functions": "nlme"}
        for response in RESPONSES:
            for name, role in levels.items():
                chosen = [row for row in self.folder.table(name, "SM", response)
                          if row["chosen"] == "yes"]
                self.assertEqual(len(chosen), 1, (response, name))
                self.assert_close(chosen[0]["log_likelihood"],
                                  self.folder.fits()[("SM", response, role)]["log_likelihood"])

    def test_gain_is_the_difference_of_r2_in_percent_points(self):
        for result in self.folder.report["results"]:
            r2 = {(row["level"], row["prediction"]): float(row["r2"])
                  for row in self.folder.table("statistics", "SM", result["response"])}
            for prediction in ("population", "conditional"):
                self.assert_close(result["gain"][prediction],
                                  100 * (r2[("nlme", prediction)] - r2[("ols", "population")]))

    def test_report_shows_the_fits_of_the_library(self):
        for result in self.folder.report["results"]:
            for role, shown in result["fits"].items():
                kept = dict(self.folder.fits()[("SM", result["response"], role)])
                kept.pop("seconds")
                # Matrices of each group, which the page does not show.
                hidden = ("eblup_covariance", "eblup_by_fixed")
                kept["random"] = [{key: value for key, value in term.items() if key not in hidden}
                                  for term in kept["random"]]
                self.assertEqual(shown, kept)
            observations = result["observations"]
            pairs = self.folder.pairs("SM", result["response"], "conditional")
            self.assertEqual(observations["observed"], [observed for observed, _ in pairs])
            for shown, (_, predicted) in zip(observations["conditional"], pairs):
                self.assert_close(shown, predicted)

    def test_library_gives_the_same_predictions_in_another_run(self):
        for level, column in (("conditional", "conditional"), ("population", "population")):
            run(self.place, "predict", "study/library.json", "study/predictions.csv", "--level",
                level, "--digits", "17", "--out", "predicted.csv")
            predicted = read_csv(f"{self.place}/predicted.csv")
            for row in predicted:
                for response in RESPONSES:
                    self.assertEqual(row[f"{response}_pred"], row[f"{response}_{column}"])


class VarianceOfItsOwnColumn(unittest.TestCase):
    def test_neither_curves_nor_predictions_need_what_only_the_variance_reads(self):
        temporary = tempfile.TemporaryDirectory(prefix="silvafit-study-")
        self.addCleanup(temporary.cleanup)
        place = temporary.name
        kept = ("plot", "tree", "species", "x", "y", "dbh", "h")
        rows = [{name: row[name] for name in kept} for row in read_csv(EXAMPLE / "inventory.csv")]
        # Heights whose errors, but not their means, follow a column.
        for i, row in enumerate(rows):
            noise = 1 + i % 5
            row["noise"] = noise
            if row["h"]:
                row["h"] = max(2.0, float(row["h"]) + 1.5 * noise * math.sin(3.7 * i * i))
        with open(f"{place}/noisy.csv", "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
        with open(f"{place}/study.json", "w", encoding="utf-8") as file:
            json.dump({"species": ["SM"], "responses": ["h"], "candidates": {"h": ["M4"]},
                       "covariates": ["noise"], "variance_functions": ["none", "power(noise)"],
                       "maximum_random_effects": 1}, file)
        run(place, "study", "noisy.csv", "--config", "study.json", "--out", "study", *UNITS)
        folder = StudyFolder(f"{place}/study")
        mixed = [model for model in folder.library["models"] if model["role"] == "nlme"]
        self.assertEqual(mixed[0]["fit"]["variance"]["of"], "noise")
        with open(f"{place}/new.csv", "w", encoding="utf-8") as file:
            file.write("species,dbh,C,M,U,W\nSM,20,0.5,0.5,0.5,0.5\n")
        out = run(place, "predict", "study/library.json", "new.csv", "--interval", "0.9").stdout
        tree = list(csv.DictReader(out.splitlines()))[0]
        self.assertGreater(float(tree["h_pred"]), 1.3)
        self.assertEqual((tree["h_lower"], tree["flag"]), ("", "no h interval: missing noise"))


if __name__ == "__main__":
    unittest.main()
