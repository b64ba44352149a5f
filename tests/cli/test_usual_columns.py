# SPDX-License-Identifier: MIT
"""Commands with models read columns of ours under their usual spellings, as inventories are read."""

import csv
import io
import json
import subprocess
import unittest

from silvafit_program import PROGRAM, ProgramTest, stand_csv


class UsualColumns(ProgramTest):
    def setUp(self):
        super().setUp()
        ours = stand_csv()
        self.write("ours.csv", ours)
        header, rows = ours.split("\n", 1)
        self.assertEqual(header, "plot,tree,species,dbh,h,C")
        self.write("usual.csv", f"Plot_ID,Tree,Species,DBH_cm,Height,C\n{rows}")

    def rows(self, *arguments):
        return list(csv.DictReader(io.StringIO(self.run_program(*arguments).stdout)))

    def test_models_of_the_catalogue_find_their_columns(self):
        ours = self.run_json("fit", "ours.csv", "--model", "M4", "--random", "a | plot")
        usual = self.run_json("fit", "usual.csv", "--model", "M4", "--random", "a | plot")
        self.assertEqual(ours["fixed"], usual["fixed"])
        self.assertEqual(sorted(usual["random"][0]["eblup"]), ["01", "02", "03", "04", "05", "06"])
        said = self.run_program("fit", "usual.csv", "--model", "M4").stderr
        self.assertIn("note: plot is read from column Plot_ID, tree from Tree, species from Species, dbh from DBH_cm, "
                      "h from Height\n", said)

    def test_names_in_a_formula_are_those_of_the_file(self):
        self.run_program("fit", "usual.csv", "--formula", "Height ~ a + b*DBH_cm")
        error = self.run_program("fit", "usual.csv", "--formula", "h ~ a + b*DBH_cm", status=3).stderr
        self.assertIn("unknown column 'h'", error)

    def test_predictions_and_calibration(self):
        fit = self.run_program("fit", "ours.csv", "--model", "M4", "--random", "a | plot", "--json").stdout
        self.write("fit.json", fit)
        ours = self.rows("predict", "fit.json", "ours.csv", "--level", "calibrated")
        usual = self.rows("predict", "fit.json", "usual.csv", "--level", "calibrated")
        self.assertEqual([row["h_pred"] for row in ours], [row["h_pred"] for row in usual])
        self.assertEqual({row["h_trees"] for row in usual}, {"fitted"})

    def test_what_models_do_not_read_may_have_two_names(self):
        fit = self.run_program("fit", "ours.csv", "--model", "M4", "--json").stdout
        self.write("fit.json", fit)
        self.write("new.csv", "DBH_cm,X_m,x_coord,xk\n20,1,2,3\n")
        self.assertEqual(len(self.rows("predict", "fit.json", "new.csv")), 1)
        self.write("new.csv", "DBH_cm,dbh_CM\n20,21\n")
        error = self.run_program("predict", "fit.json", "new.csv", status=2).stderr
        self.assertIn("'DBH_cm' and 'dbh_CM' could both be dbh", error)

    def test_heights_are_filled_in_and_plots_keep_their_spelling(self):
        lines = (self.folder / "usual.csv").read_text(encoding="utf-8").splitlines()
        gaps = [line if number % 3 else ",".join([*line.split(",")[:4], "", line.split(",")[5]])
                for number, line in enumerate(lines[1:])]
        self.write("gaps.csv", "\n".join([lines[0], *gaps]) + "\n")
        rows = self.rows("impute", "gaps.csv", "--response", "h")
        self.assertEqual(list(rows[0]), [*lines[0].split(","), "Height_source", "Height_level", "Height_flag"])
        for row, line in zip(rows, gaps, strict=True):
            measured = line.split(",")[4]
            self.assertEqual(row["Height_source"], "measured" if measured else "imputed")
            self.assertEqual(row["Height_level"], "" if measured else "plot")
            self.assertTrue(row["Height"] == measured if measured else float(row["Height"]) > 1.3)

    def test_a_pipe_is_read_once(self):
        with open(self.folder / "usual.csv", encoding="utf-8") as file:
            text = file.read()
        done = subprocess.run([PROGRAM, "fit", "/dev/stdin", "--model", "M4", "--json"], input=text, capture_output=True,
                              text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["n"], 120)

    def test_blanks_around_names_are_no_part_of_them(self):
        text = (self.folder / "usual.csv").read_text(encoding="utf-8")
        self.write("blanks.csv", text.replace("\n01,", "\n 01 ,").replace(",SM,", ", SM,"))
        plain = self.run_json("fit", "usual.csv", "--model", "M4", "--random", "a | plot")
        blanks = self.run_json("fit", "blanks.csv", "--model", "M4", "--random", "a | plot")
        self.assertEqual(plain["random"], blanks["random"])

    def test_a_mapped_plot_keeps_its_zeros(self):
        labels = self.run_json("fit", "usual.csv", "--model", "M4", "--columns", "plot=Plot_ID", "--random",
                               "a | plot")["random"][0]["eblup"]
        self.assertEqual(sorted(labels)[0], "01")


if __name__ == "__main__":
    unittest.main()
