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
        self.assertIn("h: 34 measured, 65 imputed with the curve of their plot, 20 with the population curve, 1 left empty", done.stderr)

    def test_intervals_are_those_of_calibrated_predictions(self):
        model = ("--model", "M1", "--random", "a | plot", "--variance", "none")
        filled = self.rows(self.run_program("impute", "inventory.csv", *model, "--interval", "0.9", "--digits", "17").stdout)
        self.assertEqual(list(filled[0])[-5:], ["h_source", "h_level", "h_flag", "h_lower", "h_upper"])
        self.write("fit.json", self.run_program("fit", "inventory.csv", *model, "--json").stdout)
        predicted = self.rows(self.run_program("predict", "fit.json", "inventory.csv", "--level", "calibrated", "--interval", "0.9",
                                               "--digits", "17").stdout)
        for one, other in zip(filled, predicted, strict=True):
            if one["h_source"] != "imputed":
                self.assertEqual((one["h_lower"], one["h_upper"]), ("", ""))
                continue
            self.assertEqual((one["h"], one["h_lower"], one["h_upper"]), (other["h_pred"], other["h_lower"], other["h_upper"]))
            self.assertLess(float(one["h_lower"]), float(one["h"]))
        wrong = self.run_program("impute", "inventory.csv", "--interval", "0.9", "--add-residual", status=2).stderr
        self.assertIn("--add-residual", wrong)

    def test_a_height_or_a_diameter_that_cannot_be_is_refused(self):
        lines = self.text.splitlines()
        row = next(number for number, line in enumerate(lines[1:], 1) if line.split(",")[-2] == "")
        fields = lines[row].rsplit(",", 3)  # dbh, h, C are the last
        for dbh, h, reason in (("20", "1.2", "h: 1.2 m is not above breast height, 1.3 m"),
                               ("20", "-5", "h: -5 m is not above breast height, 1.3 m"),
                               ("-5", "", "dbh: -5 is outside the domain of the model")):
            with self.subTest(h):
                changed = ",".join([fields[0], dbh, h, fields[3]])
                self.write("odd.csv", "\n".join([*lines[:row], changed, *lines[row + 1:]]) + "\n")
                error = self.run_program("impute", "odd.csv", status=3).stderr
                self.assertIn(f"odd.csv:{row + 1}: {reason}", error)

    def test_imputed_heights_that_contradict_a_crown_base_are_flagged(self):
        self.write("hcb.csv", "plot,tree,dbh,h,hcb\n" + "".join(f"1,{i},{10 + i},{8 + 0.4 * i},3\n" for i in range(12)) +
                   "1,20,15,,14\n1,21,16,,4\n")
        rows = self.rows(self.run_program("impute", "hcb.csv", "--random", "none").stdout)
        self.assertEqual([row["h_flag"] for row in rows[-2:]], ["not above the crown base", ""])

    def test_decimal_commas_become_points_but_not_those_of_labels(self):
        lines = [next(csv.reader([line])) for line in self.text.splitlines()]
        rows = [lines[0]] + [[line[0].replace("0", "0,"), *line[1:3],
                              *(value.replace(".", ",") for value in line[3:])]
                             for line in lines[1:]]
        self.write("inventory.csv", "\n".join(";".join(row) for row in rows) + "\n")
        done = self.run_program("impute", "inventory.csv", "--response", "h")
        for old, new in zip(lines[1:], self.rows(done.stdout), strict=True):
            self.assertEqual(new["plot"], old[0].replace("0", "0,"))
            self.assertEqual(new["dbh"], old[3])
            self.assertEqual(new["C"], old[5])

    def test_json_says_what_was_done(self):
        summary = self.run_json("impute", "inventory.csv", "--out", "filled.csv")
        self.assertEqual(summary["schema"], "silvafit-impute/1")
        self.assertEqual(summary["n"], 120)
        self.assertEqual((summary["measured"], summary["missing"]), (34, 1))
        self.assertEqual(summary["imputed"], {"plot": 65, "stand": 0, "population": 20})
        self.assertEqual(summary["models"][0]["fit"]["model"], "M1")
        self.assertTrue((self.folder / "filled.csv").exists())

    def test_models_formulas_and_columns_are_a_choice(self):
        self.write("other.csv", self.text.replace("dbh", "DBH_cm"))
        summary = self.run_json("impute", "other.csv", "--columns", "dbh=DBH_cm",
                                "--model", "M4", "--random", "a | plot", "--variance", "none")
        self.assertEqual(summary["models"][0]["fit"]["model"], "M4")
        self.assertEqual(summary["models"][0]["fit"]["random"][0]["effects"], ["a"])
        plain = self.run_json("impute", "inventory.csv", "--formula", "h ~ p + q*log(dbh)",
                              "--random", "none")
        self.assertEqual(plain["imputed"], {"plot": 0, "stand": 0, "population": 85})

    def test_columns_that_are_not_there_and_plots_that_are_too_few(self):
        done = self.run_program("impute", "inventory.csv", "--group", "plt", status=3)
        self.assertIn("unknown column 'plt'", done.stderr)
        self.write("other.csv", self.text.replace("plot", "place", 1))
        done = self.run_program("impute", "other.csv")
        self.assertIn("note: the column 'plot' is missing", done.stderr)
        self.assertIn("85 with the population curve", done.stderr)
        lines = self.text.splitlines()
        one = [line for line in lines[1:] if line.split(",")[0] == lines[1].split(",")[0]]
        self.write("one.csv", "\n".join([lines[0], *one]) + "\n")
        done = self.run_program("impute", "one.csv")
        self.assertIn("note: fewer than two values of 'plot' have a measured h", done.stderr)

    def test_nested_groupings_say_whose_effects_apply(self):
        """Plots are numbered within stands; of stand 3 none is measured, of stand 2 not plot 4."""
        lines = ["stand,plot,dbh,h"]
        for stand in range(1, 9):
            for plot in range(1, 5):
                for tree in range(6):
                    dbh = 8 + 5 * tree + plot
                    # Deterministic differences between stands, plots and trees.
                    h = (3 + 0.5 * dbh + (stand * 5 % 8) * 0.7 + (stand * 3 + plot * 5) % 7 * 0.4
                         + (stand * 7 + plot * 11 + tree * 13) % 10 * 0.1)
                    has_h = tree % 3 and stand != 3 and (stand, plot) != (2, 4)
                    lines.append(f"{stand},{plot},{dbh},{h if has_h else ''}")
        self.write("nested.csv", "\n".join(lines) + "\n")
        done = self.run_program("impute", "nested.csv", "--formula", "h ~ a + b*dbh",
                                "--random", "a | stand/plot", "--variance", "none")
        self.assertIn("random a | stand; a | stand/plot", done.stderr)
        self.assertIn("6 with their stand, 24 with the population curve", done.stderr)
        for row in self.rows(done.stdout):
            if row["h_source"] == "measured":
                continue
            level = "population" if row["stand"] == "3" else "plot"
            if (row["stand"], row["plot"]) == ("2", "4"):
                level = "stand"
            self.assertEqual(row["h_level"], level)

    def test_what_is_refused(self):
        done = self.run_program("impute", "inventory.csv", "--model", "M2",
                                "--formula", "h ~ p + q*dbh", status=2)
        self.assertIn("either --formula or --model", done.stderr)
        lines = self.text.splitlines()
        # An unmeasured tree, so that it is not among those that are fitted to.
        fields = lines[3].split('"')
        self.assertTrue(fields[2].split(",")[2] == "")
        lines[3] = '"'.join([fields[0], fields[1], ",thick,,"])
        lines[3] += self.text.splitlines()[3].rsplit(",", 1)[1]
        self.write("text.csv", "\n".join(lines) + "\n")
        for options in ([], ["--formula", "h ~ p + q*dbh"], ["--by", "species"]):
            done = self.run_program("impute", "text.csv", *options, status=3)
            self.assertIn("text.csv:4: dbh: 'thick' is not a number", done.stderr)

    def test_dead_trees_are_no_evidence_unless_they_are_asked_for(self):
        """Dead trees are broken at half their height, which must not change the heights of living ones."""
        living = self.rows(self.text)
        dead = [{**row, "tree": f"d{row['tree']}", "h": str(float(row["h"]) / 2)} for row in living if row["h"] and row["dbh"]]
        rows = [{**row, "state": "LI"} for row in living] + [{**row, "state": "DS"} for row in dead]
        with (self.folder / "dead.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
        codes = ("--columns", "status=state", "--alive-codes", "LI", "--dead-codes", "DS", "--response", "h")
        alone = self.rows(self.run_program("impute", "inventory.csv", "--response", "h").stdout)
        out = self.rows(self.run_program("impute", "dead.csv", *codes).stdout)
        heights = {row["tree"]: row["h"] for row in out}
        self.assertEqual({row["tree"]: row["h"] for row in alone}, {tree: heights[tree] for tree in heights if tree[0] != "d"})
        used = self.rows(self.run_program("impute", "dead.csv", *codes, "--dead", "include").stdout)
        self.assertNotEqual([row["h"] for row in used if row["tree"][0] != "d"], [row["h"] for row in alone])

    def test_labels_that_a_spreadsheet_would_compute_are_guarded_and_read_back(self):
        labels = ["=1+1", "a;=cmd|' /C calc'!A0", "@b", "b;-c", "plain;text"]
        rows = [{**row, "species": labels[number % len(labels)]} for number, row in enumerate(self.rows(self.text))]
        with (self.folder / "labels.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
        self.run_program("impute", "labels.csv", "--response", "h", "--out", "written.csv")
        written = [row["species"] for row in self.rows((self.folder / "written.csv").read_text())]
        for cell in written:
            for part in cell.split(";"):
                self.assertNotIn(part[0], "=@+-")
        fit = self.run_json("fit", "written.csv", "--formula", "dbh ~ a", "--random", "a | species")
        self.assertEqual(sorted(set(labels)), sorted(fit["random"][0]["eblup"]))

    def test_exit_statuses(self):
        self.write("empty.csv", "plot,dbh,h\n1,10,\n1,20,\n")
        self.assertIn("no model can be fitted",
                      self.run_program("impute", "empty.csv", status=3).stderr)
        self.run_program("impute", "inventory.csv", "--response", "volume", status=3)
        self.write("few.csv", "plot,dbh,h\n1,10,12\n1,20,\n")
        self.run_program("impute", "few.csv", status=4)


if __name__ == "__main__":
    unittest.main()
