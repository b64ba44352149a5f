# SPDX-License-Identifier: MIT
"""A data frame as R's write.csv leaves it: row names in a column without a name, every name in quotes, NA."""

import csv
import sys
import unittest
from pathlib import Path

from silvafit_program import ProgramTest

sys.path.append(str(Path(__file__).resolve().parents[1] / "support"))
from r_export import write_as_r_does

SPATI = "spati.csv"


class RExport(ProgramTest):
    def setUp(self):
        super().setUp()
        write_as_r_does(SPATI, self.folder / SPATI)

    def test_a_fit_is_that_of_nlme(self):
        fit = self.run_json("fit", SPATI, "--columns", "dbh=d", "--model", "M1", "--random", "a + b | plot", "--variance", "power")
        self.assertEqual(fit["n"], 1678)
        self.assertEqual(len(fit["random"][0]["eblup"]), 56)
        # nlme 3.1-162 stops at -2388.83 (docs/quick-start.md), to the digits that its tolerance leaves.
        self.assertAlmostEqual(fit["log_likelihood"], -2388.83, delta=0.01)

    def test_an_inventory_and_its_filled_copy_keep_the_row_names(self):
        self.run_program("impute", SPATI, "--response", "h", "--columns", "dbh=d", "--out", "filled.csv", "--quiet")
        with open(self.folder / SPATI, newline="", encoding="utf-8") as file:
            before = list(csv.reader(file))
        with open(self.folder / "filled.csv", newline="", encoding="utf-8") as file:
            after = list(csv.reader(file))
        self.assertEqual(after[0][:25], before[0])
        self.assertEqual(after[0][0], "")
        self.assertEqual([row[0] for row in after], [row[0] for row in before])

    def test_stand_figures_are_those_of_the_data(self):
        with open(self.folder / SPATI, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        plots = {row["plot"]: row for row in rows}
        self.assertEqual(len(plots), 66)
        # The sides of the plots are in decimeters.
        self.write("windows.csv", "plot,wkt\n" + "".join(
            f'{plot},"POLYGON((0 0,{x} 0,{x} {y},0 {y},0 0))"\n' for plot, row in plots.items()
            for x, y in [(float(row["X"]) / 10, float(row["Y"]) / 10)]))
        stand = self.run_json("stand", SPATI, "--columns", "tree=puunro,species=pl,x=xk/10,y=yk/10,dbh=d", "--window",
                              "windows.csv", "--quiet")
        found = {plot["plot"]: plot for plot in stand["areas"]}
        self.assertEqual(set(found), set(plots))
        # N and G of the data, to their two decimals.
        for plot in ("1", "3"):
            self.assertAlmostEqual(found[plot]["stems_per_ha"], float(plots[plot]["N"]), delta=0.01)
            self.assertAlmostEqual(found[plot]["basal_area_m2_per_ha"], float(plots[plot]["G"]), delta=0.01)


if __name__ == "__main__":
    unittest.main()
