# SPDX-License-Identifier: MIT
"""Spreadsheets as people have them: each file of sheets/ is one stand, written in its own fashion."""

import csv
import io
import json
import shutil
import unittest
from pathlib import Path

from silvafit_program import ProgramTest, stand_csv

SHEETS = Path(__file__).parent / "sheets"
TREES = 48


class Sheets(ProgramTest):
    def setUp(self):
        super().setUp()
        for file in SHEETS.glob("*.csv"):
            shutil.copy(file, self.folder)

    def indices(self, name, *arguments, status=0):
        """The rows of the structural units, and what was said."""
        done = self.run_program("indices", name, "--buffer", "2", *arguments, status=status)
        return list(csv.DictReader(io.StringIO(done.stdout))), done.stderr

    def assert_same_units(self, name, *arguments):
        """The same units as those of plain.csv; returns what was said."""
        plain, _ = self.indices("plain.csv")
        rows, said = self.indices(name, *arguments)
        self.assertEqual(len(rows), TREES)
        for left, right in zip(plain, rows):
            self.assertEqual({**left, "species": ""}, {**right, "species": ""})
        return said

    def recognized(self, name, *arguments):
        return self.run_json("stand", name, *arguments)["recognized"]

    # Names and units

    def test_plain(self):
        rows, said = self.indices("plain.csv")
        self.assertEqual(len(rows), TREES)
        self.assertEqual(self.recognized("plain.csv"), [])
        self.assertNotIn("rows skipped", said)

    def test_german_with_decimal_commas_and_millimeters(self):
        said = self.assert_same_units("german.csv")
        self.assertIn("note: plot is read from column Probefläche, tree from Baum-Nr., species from Baumart, "
                      "x from X-Koordinate, y from Y-Koordinate, dbh from `BHD [mm]`/10, h from Höhe [m], "
                      "hcb from Kronenansatz [m], cw from Kronenbreite [m]\n", said)

    def test_french_below_titles_and_above_units(self):
        said = self.assert_same_units("french.csv")
        self.assertIn("the header is on line 3, below 2 titles or comments; the row below the header has units", said)
        self.assertIn("dbh from DHP", said)

    def test_spanish_with_tabs(self):
        self.assertIn("cw from Diámetro de copa", self.assert_same_units("spanish.csv"))

    def test_finnish_in_millimeters_and_decimeters(self):
        self.assertIn("dbh from läpimitta_mm/10, h from pituus_dm/10", self.assert_same_units("finnish.csv"))

    def test_chinese(self):
        self.assertIn("dbh from 胸径（cm）, h from 树高（m）", self.assert_same_units("chinese.csv"))

    def test_names_made_by_r_with_comments_and_blank_columns(self):
        said = self.assert_same_units("comments.csv")
        self.assertIn("dbh from dbh..mm./10", said)
        self.assertIn("below 2 titles or comments; 4 comment lines are ignored", said)

    def test_carriage_returns_and_vague_names(self):
        rows, said = self.indices("carriage-returns.csv")
        self.assertEqual(len(rows), 12)
        self.assertIn("tree is read from column Baum, species from Art, dbh from d, h from Höhe", said)

    def test_forest_inventory_analysis_in_inches_and_feet(self):
        result = self.run_json("stand", "fia.csv", "--plot-area", "400")
        self.assertEqual(result["excluded"], 6)
        self.assertIn("the table is FIA's TREE, in inches and feet: plot is read from column PLT_CN, tree from SUBP+TREE, "
                      "species from SPCD, dbh from DIA*2.54, h from HT*0.3048", result["recognized"])
        plain = self.run_json("stand", "plain.csv", "--plot-area", "400")
        # Six of 48 trees are dead, and the sizes are rounded.
        self.assertAlmostEqual(result["all"]["quadratic_mean_dbh_cm"] / plain["all"]["quadratic_mean_dbh_cm"], 1, delta=0.05)

    # Encodings

    def test_advice_on_encodings(self):
        for name, encoding in (("gb18030.csv", "GB18030"), ("latin1.csv", "CP1252"), ("utf16.csv", "UTF-16")):
            error = self.run_program("indices", name, status=3).stderr
            converted = name.replace(".csv", "-utf8.csv")
            self.assertIn(f"iconv -f {encoding} -t UTF-8 {name} > {converted}", error)

    # Missing values

    def test_codes_are_missing_values_and_no_tree_is_lost(self):
        plain, _ = self.indices("plain.csv")
        rows, said = self.indices("codes.csv")
        self.assertEqual([row["nn1"] for row in rows], [row["nn1"] for row in plain])
        self.assertNotIn("rows skipped", said)
        self.assertIn("codes read as missing values: h 9 (-, n/a, #N/A, ?, ., k.A., -999, -9999, 0), hcb 9 ", said)

    def test_further_codes(self):
        text = (SHEETS / "plain.csv").read_text(encoding="utf-8").splitlines()
        fields = text[3].split(",")
        fields[6] = "-88"
        self.write("further.csv", "\n".join([*text[:3], ",".join(fields), *text[4:]]) + "\n")
        _, said = self.indices("further.csv")
        self.assertIn("h: -88 m is not above breast height", said)
        rows, said = self.indices("further.csv", "--missing", "-88,lost")
        self.assertEqual(len(rows), TREES)
        self.assertIn("codes read as missing values: h 1 (-88)", said)

    def test_codes_in_commands_with_models(self):
        lines = stand_csv().splitlines()
        for i, code in ((3, "-"), (7, "#N/A"), (12, "-9999"), (20, "0")):
            fields = lines[i].split(",")
            fields[4] = code
            lines[i] = ",".join(fields)
        self.write("gaps.csv", "\n".join(["Heights of 2019,,,,,", *lines]) + "\n")
        fit = self.run_json("fit", "gaps.csv", "--model", "M4")
        self.assertEqual(fit["n"], 116)
        self.assertEqual(fit["recognized"], ["the header is on line 2, below 1 title or comment",
                                             "codes read as missing values: h 4 (-, #N/A, -9999, 0)"])
        # In any table 0 is a number, unless it is said.
        formula = ("--formula", "h ~ 1.3 + a*(1 - exp(-b*dbh))")
        self.assertEqual(self.run_json("fit", "gaps.csv", *formula)["n"], 117)
        self.assertEqual(self.run_json("fit", "gaps.csv", *formula, "--missing", "-9999,0")["n"], 116)
        filled = self.run_program("impute", "gaps.csv", "--response", "h").stdout
        rows = list(csv.DictReader(io.StringIO(filled)))
        self.assertEqual(len(rows), 120)
        self.assertEqual([row["h_source"] for row in rows].count("imputed"), 4)
        self.assertTrue(all(float(row["h"]) > 1.3 for row in rows))

    # Merged cells

    def test_merged_cells_are_filled_down_on_request(self):
        rows, said = self.indices("merged.csv")
        self.assertEqual(len(rows), 4)
        self.assertIn("44 rows have a plot that is empty, as in merged cells; with --fill-down plot, the value above is used", said)
        self.assert_same_units("merged.csv", "--fill-down", "plot")
        heights = "plot,dbh,h\n" + "".join(f"{'A' if i == 0 else ''},{8 + i},{6 + i / 2}\n" for i in range(20))
        self.write("heights.csv", heights)
        filled = self.run_program("impute", "heights.csv", "--response", "h", "--fill-down", "plot", "--random", "none")
        self.assertEqual({row["plot"] for row in csv.DictReader(io.StringIO(filled.stdout))}, {"A"})

    # Mixed units

    def test_plots_in_other_units_are_named(self):
        for name, plots, unit in (("mixed-mm.csv", "plot 3", "dbh seems to be in mm"),
                                  ("mixed-inches.csv", "plot 2", "dbh seems to be in in"),
                                  ("mixed-feet.csv", "plots 1, 4", "h seems to be in ft")):
            error = self.run_program("study", name, "--out", "study", status=3).stderr
            self.assertIn(f"the file mixes units: in {plots} {unit} (median h/dbh ", error)
            self.assertIn("--trust-units", error)
            self.assertFalse((self.folder / "study").exists())
            error = self.run_program("fit", name, "--model", "M4", status=3).stderr
            self.assertIn(plots, error)
            self.run_program("fit", name, "--model", "M4", "--trust-units")

    def test_a_whole_column_in_another_unit_is_named_by_every_command(self):
        trees = [(8 + i, 7 + 0.6 * i) for i in range(20)]
        for name, dbh, h, remedy in (("cm.csv", 1, 100, "h=h/100"), ("mm.csv", 10, 1, "dbh=dbh/10"),
                                     ("us.csv", 1 / 2.54, 1 / 0.3048, "h=h*0.3048,dbh=dbh*2.54")):
            rows = "".join(f"1,{i},{d * dbh:.4f},{h_m * h:.4f}\n" for i, (d, h_m) in enumerate(trees))
            self.write(name, "plot,tree,dbh,h\n" + rows)
            for command in (("stand", name, "--plot-area", "1000"), ("fit", name, "--model", "M4"),
                            ("impute", name, "--response", "h", "--random", "none")):
                self.assertIn(f"use --columns {remedy};", self.run_program(*command, status=3).stderr)
            self.run_program("fit", name, "--formula", "h ~ a*dbh^b", "--start", "a=1,b=1", "--trust-units")

    def test_stands_that_differ_are_no_mixture(self):
        # A thicket, an old stand and a row of pollards.
        kinds = ((lambda i: (2 + 0.2 * i, 4 + 0.2 * i)), (lambda i: (60 + 2 * i, 32 + 0.2 * i)),
                 (lambda i: (50 + 2 * i, 7 + 0.05 * i)), (lambda i: (15 + i, 14 + 0.5 * i)))
        rows = [f"{plot},{i},{kind(i)[0]:.1f},{kind(i)[1]:.1f}" for plot, kind in enumerate(kinds) for i in range(15)]
        self.write("kinds.csv", "plot,tree,dbh,h\n" + "\n".join(rows) + "\n")
        self.assertNotIn("mixes", self.run_program("stand", "kinds.csv", "--plot-area", "400").stderr)

    # Species and status

    def test_spellings_of_a_species_are_one(self):
        said = self.assert_same_units("spellings.csv")
        self.assertIn("species that differ only in capitals or spaces are treated as one: ", said)
        self.assertIn("'sm' as 'SM' (3 trees)", said)
        rows, _ = self.indices("spellings.csv", "--case-sensitive")
        self.assertEqual({row["species"] for row in rows}, {"SM", "OF", "sm", "of"})

    def test_species_with_commas_are_quoted_in_lists(self):
        error = self.run_program("study", "commas.csv", "--species", "Schima", "--out", "study", status=2).stderr
        self.assertIn("'Osmanthus fragrans, Lour.', 'Schima superba, Gardn.'",
                      error.replace("'Schima superba, Gardn.', 'Osmanthus fragrans, Lour.'",
                                    "'Osmanthus fragrans, Lour.', 'Schima superba, Gardn.'"))

    def test_dead_trees_are_no_neighbors_unless_asked_for(self):
        rows, said = self.indices("status.csv")
        self.assertEqual(len(rows), 32)
        self.assertIn("the status of trees is read from column status: 8 dead, 8 cut or gone, skipped; with --dead neighbors, dead trees count as neighbors", said)
        rows, said = self.indices("status.csv", "--dead", "neighbors")
        self.assertEqual(len(rows), 40)
        dead = {(row["plot"], row["tree"]) for row in rows if int(row["tree"]) in (7, 9)}
        self.assertEqual(len(dead), 8)
        self.assertTrue(all(row["core"] == "0" for row in rows if (row["plot"], row["tree"]) in dead))
        self.assertIn("dead trees are neighbors only, the others are skipped", said)
        self.assert_same_units("status.csv", "--dead", "include")
        plots = {name: self.run_json("stand", "status.csv", "--plot-area", "400", "--dead", name)["all"]["stems_per_ha"]
                 for name in ("leave-out", "neighbors", "include")}
        self.assertEqual(plots["leave-out"], plots["neighbors"])
        self.assertAlmostEqual(plots["include"] / plots["leave-out"], 48 / 32)

    def test_status_in_german(self):
        rows, said = self.indices("zustand.csv", "--excluded", "excluded.csv")
        self.assertEqual(len(rows), 36)
        self.assertIn("read from column Zustand: 4 dead, 8 cut or gone", said)
        excluded = (self.folder / "excluded.csv").read_text(encoding="utf-8")
        self.assertIn("10,1,9,Zustand,tot,the tree is dead\n", excluded)
        self.assertIn("Zustand,Stubben,\"the tree is cut, fallen or a stump\"\n", excluded)

    def test_a_fit_says_that_dead_trees_are_among_the_rows(self):
        said = self.run_program("fit", "status.csv", "--model", "M4").stderr
        self.assertIn("8 dead, 8 cut or gone, which are used as living trees", said)

    # Records

    def test_records_tell_what_was_recognized(self):
        self.run_program("study", "german.csv", "--out", "study", "--minimum-trees", "30", "--responses", "h",
                         "--buffer", "0", "--missing", "-88")
        run = json.loads((self.folder / "study" / "run.json").read_text(encoding="utf-8"))
        self.assertIn("dbh from `BHD [mm]`/10", run["recognized"][0])
        self.assertEqual(run["options"]["missing"], ["-88"])
        self.assertEqual(run["options"]["minimum_trees"], 30)
        result = self.run_json("indices", "german.csv")
        self.assertEqual(result["recognized"], run["recognized"])
        library = str(self.folder / "study" / "library.json")
        predicted = self.run_json("predict", library, "finnish.csv", "--role", "ols")
        self.assertIn("dbh from läpimitta_mm/10", predicted["recognized"][0])


if __name__ == "__main__":
    unittest.main()
