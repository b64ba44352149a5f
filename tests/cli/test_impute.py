# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit impute`."""

import csv
import io
import unittest

from silvafit_program import ProgramTest, stand_csv


def with_gaps(text, keep=3):
    """Only every third height is left, none in plot 06; one tree has no dbh."""
    lines = text.splitlines()
    result = [lines[0]]
    for number, line in enumerate(lines[1:]):
        plot, tree, species, dbh, h, crowding = line.split(",")
        if number % keep or plot == "06":
            h = ""
        if number == 1:
            dbh = ""
        result.append(",".join([plot, tree, f'"{species}, old"', dbh, h, crowding]))
    return "\n".join(result) + "\n"


class Impute(ProgramTest):
    def setUp(self):
        super().setUp()
        self.text = with_gaps(stand_csv())
        self.write("inventory.csv", self.text)

    def rows(self, text):
        return list(csv.DictReader(io.StringIO(text)))

    def test_columns_stay_and_heights_are_filled_in(self):
        done = self.run_program("impute", "inventory.csv", "--response", "h")
        before = self.rows(self.text)
        after = self.rows(done.stdout)
        self.assertEqual(list(after[0])[-3:], ["h_source", "h_level", "h_flag"])
        for old, new in zip(before, after, strict=True):
            for name in ("plot", "tree", "species", "dbh", "C"):
                self.assertEqual(old[name], new[name])
            if old["h"]:
                self.assertEqual((new["h"], new["h_source"], new["h_level"]),
                                 (old["h"], "measured", ""))
            elif not old["dbh"]:
                self.assertEqual((new["h"], new["h_source"], new["h_flag"]),
                                 ("", "missing", "dbh is missing"))
            else:
                self.assertEqual(new["h_source"], "imputed")
                self.assertGreater(float(new["h"]), 1.3)
                level = "population" if old["plot"] == "06" else "plot"
                self.assertEqual(new["h_level"], level)
        self.assertIn("h: 34 measured, 65 imputed with their plot, 20 with the population's curve, "
                      "1 left empty", done.stderr)

    def test_json_says_what_was_done(self):
        summary = self.run_json("impute", "inventory.csv", "--out", "filled.csv")
        self.assertEqual(summary["schema"], "silvafit-impute/1")
        self.assertEqual(summary["n"], 120)
        self.assertEqual((summary["measured"], summary["missing"]), (34, 1))
        self.assertEqual(summary["imputed"], {"plot": 65, "population": 20})
        self.assertEqual(summary["models"][0]["fit"]["model"], "M1")
        self.assertTrue((self.folder / "filled.csv").exists())

    def test_models_formulas_and_columns_are_a_choice(self):
        self.write("other.csv", self.text.replace("dbh", "DBH_cm"))
        summary = self.run_json("impute", "other.csv", "--columns", "dbh=DBH_cm",
                                "--model", "M4", "--random", "a | plot", "--variance", "none")
        self.assertEqual(summary["models"][0]["fit"]["model"], "M4")
        self.assertEqual(summary["models"][0]["fit"]["random"]["effects"], ["a"])
        plain = self.run_json("impute", "inventory.csv", "--formula", "h ~ p + q*log(dbh)",
                              "--random", "none")
        self.assertEqual(plain["imputed"], {"plot": 0, "population": 85})

    def test_exit_statuses(self):
        self.write("empty.csv", "plot,dbh,h\n1,10,\n1,20,\n")
        self.assertIn("nothing to fit to",
                      self.run_program("impute", "empty.csv", status=3).stderr)
        self.run_program("impute", "inventory.csv", "--response", "volume", status=2)
        self.write("few.csv", "plot,dbh,h\n1,10,12\n1,20,\n")
        self.run_program("impute", "few.csv", status=4)


if __name__ == "__main__":
    unittest.main()
