# SPDX-License-Identifier: MIT
"""Studies: what is checked before the fits, what is left behind, and settings that come back as they were given."""

import csv
import json
import math
import os
import random
import subprocess
import unittest
from pathlib import Path

from silvafit_program import PROGRAM, ProgramTest, stand_csv


class ProgramWithoutPages(ProgramTest):
    """A data folder such as SILVAFIT_BUILD_VIEWER=OFF leaves it."""

    def setUp(self):
        super().setUp()
        self.write("trees.csv", stand_csv())
        models = Path(__file__).parents[2] / "models"
        (self.folder / "share").mkdir()
        os.symlink(models, self.folder / "share" / "models")

    def run_without_pages(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=120,
                              check=False, env={**os.environ, "SILVAFIT_DATA_DIR": str(self.folder / "share")})
        return done.returncode, done.stderr

    def test_is_refused_before_anything_is_read_or_made(self):
        # The inventory is not there, which would be said first if it were read.
        status, error = self.run_without_pages("study", "none.csv", "--out", "out")
        self.assertEqual(status, 3)
        self.assertIn("viewer/report.html: the page template was not found", error)
        self.assertIn("-DSILVAFIT_BUILD_VIEWER=ON", error)
        self.assertFalse((self.folder / "out").exists())
        status, error = self.run_without_pages("view", "none.csv", "--no-open")
        self.assertEqual(status, 3)
        self.assertIn("viewer/scene.html: the page template was not found", error)

    def test_settings_to_start_from_need_no_page(self):
        self.assertEqual(self.run_without_pages("study", "trees.csv", "--init", "study.json")[0], 0)


class StudyOfAWorkbook(ProgramTest):
    def test_has_all_files_as_that_of_a_csv_file_has(self):
        draw = random.Random(5)
        rows = [f"1,{tree},A,{draw.uniform(0, 30):.1f},{draw.uniform(0, 30):.1f},{dbh},{1.3 + dbh * dbh / (0.2 * dbh + 1) ** 2:.1f}"
                for tree, dbh in enumerate(range(8, 48), 1)]
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h\n" + "\n".join(rows) + "\n")
        for book in ("trees.xlsx", "trees.ods"):
            self.run_program("indices", "trees.csv", "--out", book)
            self.run_program("study", book, "--out", "study", "--minimum-trees", "20", "--edge", "none")
            names = {path.name for path in (self.folder / "study").iterdir()}
            self.assertLessEqual({"library.json", "predictions.csv", "report.html", "run.json"}, names)
            self.run_program("stand", book, "--report", "stand.html")
            self.assertIn(f"{book} (sheet ", (self.folder / "stand.html").read_text(encoding="utf-8"))


class FolderOfResults(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("bare.csv", "g,x,y\n1,1,2\n1,2,2.5\n")

    def test_goes_with_the_study_that_failed(self):
        self.run_program("study", "bare.csv", "--out", "new/deep/", status=3)
        self.assertFalse((self.folder / "new").exists())
        self.run_program("study", "bare.csv", "--out", "new", status=3)
        self.assertFalse((self.folder / "new").exists())

    def test_stays_where_it_was_there_before(self):
        (self.folder / "old").mkdir()
        self.run_program("study", "bare.csv", "--out", "old/new", status=3)
        self.assertEqual(list((self.folder / "old").iterdir()), [])
        self.run_program("study", "bare.csv", "--out", "old", status=3)
        self.assertTrue((self.folder / "old").is_dir())


def german_csv():
    """The stand under other names and in other units, with a column that may be a covariate."""
    lines = ["Parzelle;BHD [mm];H\u00f6he (dm);Art;Neigung"]
    for row in stand_csv().splitlines()[1:]:
        plot, tree, species, dbh, h, _ = row.split(",")
        lines.append(f"{plot};{float(dbh) * 10:.0f};{str(round(float(h) * 10, 1)).replace('.', ',')};{species};{tree}")
    return "\n".join(lines) + "\n"


COLUMNS = "plot=Parzelle,species=Art,dbh=`BHD [mm]`/10,h=`H\u00f6he (dm)`/10"
OPTIONS = ("--columns", COLUMNS, "--edge", "none", "--buffer", "2.5", "--minimum-trees", "50", "--species", "SM",
           "--responses", "h", "--covariates", "Neigung", "--criterion", "aicc", "--alpha", "70,SM=60",
           "--dominance", "h", "--neighbors", "3", "--trust-units")
SETTINGS = {"species": ["SM"], "minimum_trees": 50, "responses": ["h"], "covariates": ["Neigung"], "group": "plot",
            "criteria": dict.fromkeys(("base", "covariates", "random", "variance"), "aicc"), "tests": "shown",
            "columns": dict(part.split("=") for part in COLUMNS.split(",")), "window": None, "edge": "none",
            "buffer": 2.5, "alpha": ["70", "SM=60"], "dominance": "h", "neighbors": 3, "trust_units": True}


class CovariatesOfPlots(ProgramTest):
    def test_are_doubtful_where_only_independent_trees_would_tell(self):
        # An elevation of each plot that has no effect, beside limits of plots that differ by 2 m.
        draw = random.Random(2)
        rows = ["plot,tree,species,dbh,h,elev,age"]
        for plot in range(12):
            limit, elev = 26 + draw.gauss(0, 2), draw.uniform(100, 400)
            for tree in range(20):
                dbh = draw.uniform(8, 45)
                h = 1.3 + limit * (1 - math.exp(-0.06 * dbh)) + draw.gauss(0, 1)
                rows.append(f"{plot},{tree},A,{dbh:.1f},{h:.2f},{elev:.0f},{'' if tree else 50 + tree}")
        self.write("trees.csv", "\n".join(rows) + "\n")
        study = ("study", "trees.csv", "--responses", "h", "--minimum-trees", "50", "--out", "out")
        result = self.run_json(*study, "--covariates", "elev")["results"][0]
        self.assertEqual(result["covariates"], "a ~ 1 + elev")
        self.assertFalse(result["sound"])
        self.assertTrue(any(doubt.startswith("Covariates with one value in each plot were chosen as if trees were independent")
                            and "elev (p = 0.5)" in doubt for doubt in result["doubts"]))

    def test_what_trees_lack_is_called_by_its_name(self):
        self.write("trees.csv", stand_csv())
        lines = stand_csv().splitlines()
        rows = [line + (f",{40 + row % 30}" if row % 3 else ",") for row, line in enumerate(lines[1:])]
        self.write("aged.csv", "\n".join([lines[0] + ",age", *rows]) + "\n")
        study = self.run_json("study", "aged.csv", "--covariates", "age", "--minimum-trees", "30", "--out", "out")
        notes = [note for result in study["results"] for note in result["notes"]]
        self.assertTrue(any(note.endswith("trees without age were excluded.") for note in notes))
        study = self.run_json("study", "trees.csv", "--covariates", "stems_per_ha,BAL", "--out", "out")
        self.assertTrue(any("needs" in note and "which the inventory does not have" in note for note in study["notes"]))

    def test_required_tests_hold_beside_a_criterion(self):
        self.write("trees.csv", stand_csv())
        self.run_program("study", "trees.csv", "--criterion", "bic", "--tests", "required", "--significance", "0.01", "--out", "out")
        options = json.loads((self.folder / "out" / "run.json").read_text(encoding="utf-8"))["options"]
        self.assertEqual((options["tests"], options["significance"]), ("required", 0.01))
        self.run_program("study", "trees.csv", "--criterion", "bic", "--out", "out")
        options = json.loads((self.folder / "out" / "run.json").read_text(encoding="utf-8"))["options"]
        self.assertEqual(options["tests"], "shown")


class Settings(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("de.csv", german_csv())

    def text(self, name):
        return (self.folder / name).read_text(encoding="utf-8")

    def options(self, folder):
        return json.loads(self.text(f"{folder}/run.json"))["options"]

    def test_a_file_to_start_from_says_what_the_options_say_and_runs_as_it_is(self):
        self.run_program("study", "de.csv", "--init", "study.json", *OPTIONS)
        lines = [line.split("  //")[0] for line in self.text("study.json").splitlines()
                 if not line.strip().startswith("//")]
        written = json.loads("\n".join(lines))
        self.assertEqual({key: written[key] for key in SETTINGS}, SETTINGS)
        # Of the columns that are left, one may be a covariate; what dbh and h are made from may not.
        self.assertIn("// columns of the file: Neigung\n", self.text("study.json"))
        self.run_program("study", "de.csv", "--config", "study.json", "--out", "out")
        options = self.options("out")
        self.assertEqual({key: options[key] for key in SETTINGS}, SETTINGS)

    def test_a_run_can_be_repeated_by_what_it_recorded(self):
        self.run_program("study", "de.csv", "--init", "study.json", *OPTIONS)
        self.run_program("study", "de.csv", "--config", "study.json", "--out", "first")
        self.write("study.json", "{}")
        self.run_program("study", "de.csv", "--config", "first/run.json", "--out", "second")
        self.assertEqual(self.options("second"), self.options("first"))
        self.assertEqual(self.text("second/library.json"), self.text("first/library.json"))
        # Options of the command line come before the record.
        self.run_program("study", "de.csv", "--config", "first/run.json", "--criterion", "bic", "--out", "third")
        self.assertEqual(self.options("third")["criteria"]["base"], "bic")
        self.assertEqual(self.options("third")["columns"], SETTINGS["columns"])

    def test_a_window_is_recorded_as_seen_from_the_folder(self):
        trees = Path(__file__).parents[2] / "examples" / "fir-mixed"
        (self.folder / "areas").mkdir()
        self.write("areas/w.geojson", (trees / "window.geojson").read_text(encoding="utf-8"))
        study = ("study", str(trees / "inventory.csv"), "--species", "SM", "--responses", "h", "--quiet")
        self.run_program(*study, "--per", "stand", "--window", "areas/w.geojson", "--out", "deep/first")
        self.assertEqual(self.options("deep/first")["window"], "../../areas/w.geojson")
        self.run_program(*study, "--config", "deep/first/run.json", "--out", "second")
        self.assertEqual(self.text("second/indices.csv"), self.text("deep/first/indices.csv"))
        self.assertEqual(self.options("second")["window"], "../areas/w.geojson")
        error = self.run_program(*study, "--config", "other.json", "--out", "third", status=3).stderr
        self.assertIn("other.json", error)

    def test_a_circle_and_a_window_exclude_each_other(self):
        self.write("both.json", '{"window": "w.geojson", "circle": "0,0,9"}')
        error = self.run_program("study", "de.csv", "--config", "both.json", "--out", "o", status=3).stderr
        self.assertIn("both.json: circle: give either a circle or a window", error)


class CoreTrees(ProgramTest):
    def test_are_counted_where_not_all_trees_are_core(self):
        # On a grid of 1 m, 3 by 3 trees of 7 by 7 are 2 m and more from the hull.
        rows = [f"1,{7 * x + y},SM,{x},{y},20" for x in range(7) for y in range(7)]
        self.write("grid.csv", "\n".join(["plot,tree,species,x,y,dbh", *rows]) + "\n")
        indices = ("indices", "grid.csv", "--out", "i.csv")
        note = "9 of 49 trees are core trees; 40 are near the boundary or have no structural unit"
        self.assertIn(f"note: {note}\n", self.run_program(*indices, "--buffer", "2").stderr)
        self.assertNotIn("core trees", self.run_program(*indices, "--edge", "none").stderr)


class OwnFormulas(ProgramTest):
    def test_are_shown_as_the_base_model(self):
        formula = "h ~ 1.3 + top*(1 - exp(-rate*dbh))"
        self.write("trees.csv", stand_csv())
        self.write("study.json", json.dumps({"responses": ["h"], "covariates": [], "candidates": {"h": [formula]}}))
        study = ("study", "trees.csv", "--config", "study.json", "--out", "out")
        row = next(line for line in self.run_program(*study).stdout.splitlines() if line.startswith("SM"))
        self.assertIn(f"  120  {formula}  ", row)
        result = self.run_json(*study)["results"][0]
        self.assertIsNone(result["model"])
        self.assertEqual(result["formula"], formula)
        with open(self.folder / "out" / "tables" / "candidates.csv", encoding="utf-8") as table:
            self.assertEqual([row["model"] for row in csv.DictReader(table)], ["own"])


class Settings(ProgramTest):
    def test_a_new_settings_file_is_named_in_json(self):
        self.write("stand.csv", stand_csv())
        written = self.run_json("study", "stand.csv", "--init", "study.json")
        self.assertEqual(written["settings"], "study.json")
        self.assertTrue((self.folder / "study.json").is_file())


if __name__ == "__main__":
    unittest.main()
