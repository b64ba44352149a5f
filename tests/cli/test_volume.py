# SPDX-License-Identifier: MIT
"""Volume, biomass and carbon by equations of the catalogue and of files (docs/stand.md)."""

import csv
import json
import math
import subprocess
import sys
import unittest
from pathlib import Path

from silvafit_program import ProgramTest, stand_csv

SOURCE = Path(__file__).resolve().parents[2]


def value_in_r(model, dbh_cm, h_m):
    """A model of allometric in its own units, evaluated by Python."""
    lengths = {"cm": dbh_cm, "in": dbh_cm / 2.54}
    heights = {"m": h_m, "ft": h_m / 0.3048}
    units = {one["name"]: one["unit"] for one in model["covariates"]}
    names = {"exp": math.exp, "log": math.log, **model["parameters"], "dsob": lengths[units["dsob"]]}
    if "hst" in units:
        names["hst"] = heights[units["hst"]]
    value = eval(model["predict_fn_body"][0].replace("^", "**"), {}, names)
    return value * {"ft3": 0.3048**3, "ft^3": 0.3048**3, "kg": 1, "g": 0.001}[model["response"]["unit"]]


class Volume(ProgramTest):
    def test_ten_models_of_allometric_become_equations(self):
        models = json.loads((SOURCE / "tests/data/allometric.json").read_text())
        done = subprocess.run([sys.executable, SOURCE / "scripts/allometric-equations", SOURCE / "tests/data/allometric.json", "--out",
                               self.folder / "equations.json"], capture_output=True, text=True, check=True)
        self.assertIn("model height of hughes_1999 is skipped: the response hst is neither", done.stderr)
        self.assertIn("model mixed of someone_2020 is skipped: it is a MixedEffectsModel", done.stderr)
        equations = json.loads((self.folder / "equations.json").read_text())["equations"]
        self.assertEqual(len(equations), 10)
        self.assertEqual(equations[0]["species"], ["Tsuga mertensiana"])
        self.assertEqual(equations[1]["species"], ["Acer"])
        self.write("trees.csv", "plot,tree,species,dbh,h\n1,1,A,18.3,14.5\n1,2,A,31.2,21\n")
        for model, equation in zip(models, equations):
            with self.subTest(equation["id"]):
                result = self.run_json("stand", "trees.csv", "--plot-area", "10000", "--equation-file", "equations.json", "--equations",
                                       equation["id"])
                unit = "m3" if equation["quantity"] == "volume" else "kg"
                total = result["all"][f"{equation['quantity']}_{unit}_per_ha"]
                expected = value_in_r(model, 18.3, 14.5) + value_in_r(model, 31.2, 21)
                self.assertAlmostEqual(total / expected, 1, delta=1e-12)

    def test_quantities_of_plots_strata_and_growth(self):
        self.write("trees.csv", "plot,tree,species,year,dbh\n1,1,A,2010,20\n2,1,A,2010,30\n1,1,A,2020,24\n2,1,A,2020,33\n")
        biomass = lambda dbh: math.exp(-2.5356 + 2.4349 * math.log(dbh))
        equations = ("--plot-area", "1000", "--equations", "jenkins-pine,ipcc-carbon")
        stand = self.run_json("stand", "trees.csv", *equations)
        plots = [10 * biomass(24), 10 * biomass(33)]  # of the last visit
        self.assertAlmostEqual(stand["areas"][0]["biomass_kg_per_ha"], plots[0], delta=1e-9)
        estimate = stand["strata"][0]["carbon_kg"]
        self.assertAlmostEqual(estimate["per_ha"], 0.47 * sum(plots) / 2, delta=1e-9)
        # Two plots: the standard error of their mean is half their difference.
        self.assertAlmostEqual(estimate["standard_error"], 0.47 * (plots[1] - plots[0]) / 2, delta=1e-9)
        growth = self.run_json("stand", "trees.csv", "--growth", *equations)
        self.assertAlmostEqual(growth["plots"][0]["biomass_kg"]["survivor_growth"], 10 * (biomass(24) - biomass(20)) / 10, delta=1e-9)

    def test_predictions_have_volumes_of_predicted_heights(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_program("fit", "stand.csv", "--model", "M4", "--json").stdout
        self.write("fit.json", fit)
        self.write("new.csv", "plot,tree,species,dbh,h\n99,1,SM,22,\n99,2,SM,22,15\n")
        self.run_program("predict", "fit.json", "new.csv", "--digits", "15", "--equations", "laasasenaho-spruce", "--out", "out.csv")
        with open(self.folder / "out.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        for row, h in zip(rows, (float(rows[0]["h_pred"]), 15.0)):
            volume = 0.022927e-3 * 22**1.91505 * 0.99146**22 * h**2.82541 * (h - 1.3)**-1.53547
            self.assertAlmostEqual(float(row["volume_m3"]) / volume, 1, delta=1e-9)

    def test_the_catalogue_lists_equations(self):
        text = self.run_program("models", "--equations").stdout
        self.assertIn("chave-2014", text)
        entry = self.run_json("models", "jenkins-pine", "--equations")["equations"][0]
        self.assertEqual(entry["domain"]["dbh"], [2.5, 180])
        self.write("trees.csv", "plot,tree,dbh\n1,1,20\n")
        message = self.run_program("stand", "trees.csv", "--plot-area", "400", "--equations", "jenkins-pin", status=2).stderr
        self.assertIn("unknown equation 'jenkins-pin'", message)


if __name__ == "__main__":
    unittest.main()
