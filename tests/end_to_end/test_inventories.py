# SPDX-License-Identifier: MIT
"Studies of inventories that are not as one would wish: bad rows, odd names, one plot, no tree positions."

import json
import math
import random
import unittest

from silvafit_program import ProgramTest
from study_folder import StudyFolder, run_node

HEADER = "plot,tree,species,x,y,dbh,h,hcb"


def rows_of(species="SM", plots=4, trees=60, seed=5):
    """Rows of trees on plots of 40 m x 40 m, their heights a Meyer curve whose limit varies by plot."""
    draw = random.Random(seed)
    rows = []
    for plot in range(1, plots + 1):
        limit = 26 + 3 * draw.gauss(0, 1)
        for tree in range(1, trees + 1):
            dbh = round(draw.uniform(6, 45), 1)
            h = round(1.3 + limit * (1 - math.exp(-0.05 * dbh)) + draw.gauss(0, 0.6), 1)
            hcb = round(h * draw.uniform(0.35, 0.45), 1)
            x, y = round(40 * plot + draw.uniform(0, 40), 2), round(draw.uniform(0, 40), 2)
            rows.append([str(plot), f"{species[:1]}{tree}", species, x, y, dbh, h, hcb])
    return rows


def quoted(text):
    return '"' + str(text).replace('"', '""') + '"'


class Inventories(ProgramTest):
    def write_rows(self, rows, header=HEADER):
        lines = [",".join(quoted(field) for field in row) for row in rows]
        return self.write("stand.csv", "\n".join([header, *lines]) + "\n")

    def study(self, *arguments, status=0):
        self.done = self.run_program("study", "stand.csv", "--out", "out", *arguments,
                                     status=status)
        return StudyFolder(self.folder / "out")

    def assert_report_opens(self):
        opened = run_node("SILVAFIT_CHECK_REPORT", self.folder / "out" / "report.html")
        self.assertEqual(opened.returncode, 0, opened.stderr)

    def test_rows_that_cannot_be_right_are_listed_and_left_out(self):
        rows = rows_of()
        rows[3][5] = 0          # dbh: a missing value, so that the tree is only a neighbor of others
        rows[10][6] = 1.1       # h
        rows[20][7] = 60        # hcb above h
        rows[30][5] = "thick"   # no number
        self.write_rows(rows)
        folder = self.study("--minimum-trees", "80")
        lines = [int(row["line"]) for row in folder.excluded]
        self.assertEqual(sorted(set(lines)), [12, 22, 32])
        self.assertTrue(all(row["reason"] for row in folder.excluded))
        self.assertEqual({row["value"] for row in folder.excluded if row["line"] == "32"},
                         {"thick"})
        self.assertEqual(len(folder.predictions), len(rows) - 3)
        self.assertEqual(folder.report["inventory"]["excluded"], 3)
        self.assertEqual(folder.report["inventory"]["trees"], len(rows))
        self.assertIn("3 of 240 rows skipped", self.done.stderr)
        self.assertIn("1 tree is without dbh", self.done.stderr)
        self.assertNotIn("skipped", self.done.stdout)

    def test_names_that_look_like_markup_stay_names(self):
        name = "<script>alert('x')</script> & \"b\""
        rows = rows_of(name)
        for row in rows:
            row[0] = f"<b>{row[0]}\""
            row[1] = f"{row[1]}\"><img src=x onerror=alert(1)>"
        self.write_rows(rows)
        folder = self.study("--responses", "h")
        result, = folder.report["results"]
        self.assertEqual(result["species"], name)
        self.assertIn("<b>1\"", result["observations"]["plot"])
        page = (self.folder / "out" / "report.html").read_text(encoding="utf-8")
        self.assertNotIn("<img", page)
        self.assertNotIn("<script>alert", page)
        # It opens without an error, and what it saves is what the program wrote.
        self.assert_report_opens()

    def test_names_in_chinese_with_commas_and_quotes_stay_as_they_are(self):
        names = ["杉木", '木荷, "实生"']
        self.write_rows(rows_of(names[0]) + rows_of(names[1], seed=6))
        folder = self.study("--responses", "h")
        self.assertEqual({key[0] for key in folder.fits()}, set(names))
        self.assertEqual({row["species"] for row in folder.tables["statistics"]}, set(names))
        self.assertEqual({row["species"] for row in folder.predictions}, set(names))
        self.assertEqual([result["species"] for result in folder.report["results"]], names)
        self.assert_report_opens()
        self.run_program("predict", "out/library.json", "out/predictions.csv", "--level",
                         "conditional", "--out", "predicted.csv")
        self.run_program("study", "stand.csv", "--out", "one", "--species", names[0],
                         "--responses", "h")
        self.assertEqual({key[0] for key in StudyFolder(self.folder / "one").fits()}, {names[0]})

    def test_one_plot_has_no_mixed_models_and_says_so(self):
        self.write_rows(rows_of(plots=1, trees=250))
        folder = self.study("--responses", "h")
        self.assertEqual({role for _, _, role in folder.fits()}, {"ols", "covariates"})
        self.assertEqual(folder.tables["random_effects"], [])
        self.assertIn("h_ols", folder.predictions[0])
        self.assertNotIn("h_conditional", folder.predictions[0])
        result = folder.report["results"][0]
        self.assertTrue(result["converged"])
        self.assertIn("one plot: level 3 was skipped", result["verdict"])
        self.assertEqual(result["gain"], {"population": None, "conditional": None})
        self.assert_report_opens()

    def test_without_positions_level_2_is_left_out_with_a_sentence(self):
        self.write_rows([row[:3] + row[5:] for row in rows_of()],
                        header="plot,tree,species,dbh,h,hcb")
        folder = self.study()
        self.assertNotIn("indices.csv", folder.files())
        self.assertEqual(folder.tables["covariates"], [])
        notes = " ".join(folder.report["notes"])
        self.assertIn("no tree positions", notes)
        self.assertIn("no tree positions", self.done.stderr)
        self.assertIn("no column cw", notes)
        decisions = {option["name"]: option["value"] for option in folder.report["options"]}
        self.assertIn("skipped", decisions["Level 2"])
        self.assert_report_opens()

    def test_species_with_few_trees_are_noted(self):
        self.write_rows(rows_of() + rows_of("rare", plots=1, trees=20))
        folder = self.study("--responses", "h", "--minimum-trees", "80")
        self.assertEqual({key[0] for key in folder.fits()}, {"SM"})
        self.assertTrue(any("rare h" in note for note in folder.report["notes"]))
        self.assertEqual({row["h_ols"] for row in folder.predictions if row["species"] == "rare"},
                         {""})
        studied = {row["code"]: row["studied"] for row in folder.report["inventory"]["species"]}
        self.assertEqual(studied, {"SM": True, "rare": False})

    def test_exit_statuses_say_whose_fault_it_is(self):
        self.write_rows(rows_of(trees=20))
        self.run_program("study", "stand.csv", status=2)
        self.assertIn("OF", self.run_program("study", "stand.csv", "--out", "out", "--species",
                                             "OF", status=2).stderr)
        self.assertIn("volume", self.run_program("study", "stand.csv", "--out", "out",
                                                 "--responses", "volume", status=2).stderr)
        self.run_program("study", "missing.csv", "--out", "out", status=3)
        self.write("empty.csv", HEADER + "\n")
        self.run_program("study", "empty.csv", "--out", "out", status=3)

    def test_a_study_without_any_model_still_leaves_its_reasons(self):
        self.write_rows(rows_of(plots=2, trees=15))
        folder = self.study("--json", status=4)
        summary = json.loads(self.done.stdout)
        self.assertEqual(summary["results"], [])
        self.assertTrue(any("Too few trees" in note for note in summary["notes"]))
        self.assertEqual(folder.library["models"], [])
        self.assert_report_opens()


if __name__ == "__main__":
    unittest.main()
