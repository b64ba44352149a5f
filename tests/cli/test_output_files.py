# SPDX-License-Identifier: MIT
"""No command writes over what it reads, nor over what else it writes."""

import json
import os
import subprocess
import unittest

from silvafit_program import PROGRAM, ProgramTest, stand_csv

POSITIONS = "plot,tree,species,x,y,dbh,h,hcb,cw\n" + "".join(
    f"1,{tree},SM,{3 * (tree % 5) + 0.1 * tree:.1f},{3 * (tree // 5) + 0.2:.1f},{10 + tree},{8 + 0.5 * tree},3,2.5\n"
    for tree in range(25))


class OutputFiles(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("trees.csv", stand_csv())
        self.write("positions.csv", POSITIONS)

    def refused(self, *arguments, options, kept):
        """Status 2, both options named, and the file as it was."""
        before = (self.folder / kept).read_bytes()
        error = self.run_program(*arguments, status=2).stderr
        for option in options:
            self.assertIn(option, error)
        self.assertIn("are the same file", error)
        self.assertEqual((self.folder / kept).read_bytes(), before)

    def fitted(self, name):
        fit = self.run_program("fit", "trees.csv", "--model", "M4", "--json").stdout
        return self.write(name, fit)

    def test_a_table_is_not_written_over_the_inventory(self):
        for arguments, options in (
                (("indices", "positions.csv", "--out", "positions.csv"), ("--out", "INVENTORY.csv")),
                (("indices", "positions.csv", "--excluded", "positions.csv"), ("--excluded", "INVENTORY.csv")),
                (("impute", "positions.csv", "--out", "positions.csv"), ("--out", "INVENTORY.csv")),
                (("fit", "positions.csv", "--model", "M4", "--residuals", "positions.csv"),
                 ("--residuals", "DATA.csv"))):
            with self.subTest(arguments):
                self.refused(*arguments, options=options, kept="positions.csv")

    def test_tiles_are_not_overwritten_by_their_result(self):
        self.run_program("tiles", "plan", "positions.csv", "--size", "5", "--halo", "1", "--out", "tiles")
        for name in ("tiles/plan.json", next((self.folder / "tiles" / "tiles").iterdir()).relative_to(self.folder)):
            before = (self.folder / name).read_bytes()
            self.run_program("tiles", "merge", "tiles", "indices", "--out", str(name), status=2)
            self.assertEqual((self.folder / name).read_bytes(), before)
        self.refused("tiles", "merge", "tiles", "indices", "--out", "positions.csv",
                     options=("--out", "the inventory"), kept="positions.csv")

    def test_a_page_is_not_written_over_a_workbook(self):
        error = self.run_program("stand", "positions.csv", "--out", "o.xlsx", "--report", "./o.xlsx", status=2).stderr
        self.assertIn("are the same file", error)

    def test_tables_are_not_written_under_the_endings_of_other_formats(self):
        for name in ("x.geojson", "x.shp", "x.sqlite", "x.tsv", "x.csv.gz", "x.json"):
            error = self.run_program("indices", "positions.csv", "--out", name, status=2).stderr
            self.assertIn("tables are written as .csv, .xlsx, .ods, .gpkg or .fgb", error)

    def test_empty_values_are_not_taken_for_missing_options(self):
        for words, named in ((("--plot-area", ""), "--plot-area"), (("--sql=",), "--sql"), (("",), "word 3")):
            error = self.run_program("stand", "positions.csv", *words, status=2).stderr
            self.assertIn(f"{named}: the value is empty", error)

    def test_a_window_is_an_input_too(self):
        self.write("window.csv", "plot,x,y,radius\n*,5,5,9\n")
        self.refused("indices", "positions.csv", "--window", "window.csv", "--out", "window.csv",
                     options=("--out", "--window"), kept="window.csv")

    def test_other_names_of_the_same_file_are_seen_through(self):
        (self.folder / "folder").mkdir()
        os.symlink("positions.csv", self.folder / "symbolic.csv")
        os.link(self.folder / "positions.csv", self.folder / "hard.csv")
        for name in ("./positions.csv", "folder/../positions.csv", "symbolic.csv", "hard.csv",
                     str(self.folder / "positions.csv")):
            with self.subTest(name):
                self.refused("indices", "positions.csv", "--out", name,
                             options=("--out", "INVENTORY.csv"), kept="positions.csv")

    def test_predictions_are_not_written_over_trees_or_models(self):
        self.fitted("fit.json")
        self.refused("predict", "fit.json", "positions.csv", "--out", "positions.csv",
                     options=("--out", "NEW.csv"), kept="positions.csv")
        self.refused("predict", "--library", "fit.json", "positions.csv", "--out", "fit.json",
                     options=("--out", "LIBRARY.json"), kept="fit.json")
        self.refused("library", "scenes", "fit.json", "--out", "fit.json",
                     options=("--out", "LIBRARY"), kept="fit.json")
        self.fitted("other.json")
        self.refused("compare", "fit.json", "other.json", "--html", "other.json",
                     options=("--html", "FIT.json"), kept="other.json")

    def test_a_design_is_not_written_over_and_the_stand_not_by_its_truth(self):
        self.write("design.json", "{}")
        self.refused("simulate", "design.json", "--out", "design.json",
                     options=("--out", "DESIGN.json"), kept="design.json")
        self.refused("simulate", "design.json", "--out", "s.csv", "--truth", "design.json",
                     options=("--truth", "DESIGN.json"), kept="design.json")
        self.refused("simulate", "design.json", "--out", "s.csv", "--truth", "./s.csv",
                     options=("--out", "--truth"), kept="design.json")

    def test_two_tables_need_two_files(self):
        self.refused("indices", "positions.csv", "--out", "new/i.csv", "--excluded", "new/../new/i.csv",
                     options=("--out", "--excluded"), kept="positions.csv")
        self.assertFalse((self.folder / "new").exists())

    def test_an_inventory_in_the_folder_of_results_stays(self):
        (self.folder / "results").mkdir()
        for command, name in (("stand", "plots.csv"), ("study", "predictions.csv")):
            self.write(f"results/{name}", POSITIONS)
            self.refused(command, f"results/{name}", "--out", "results",
                         options=("--out", "INVENTORY.csv"), kept=f"results/{name}")
        # Beside the results is no harm.
        self.write("results/mine.csv", POSITIONS)
        self.run_program("stand", "results/mine.csv", "--out", "results", "--quiet")

    def test_scenes_pages_and_pictures(self):
        self.write("trees.glb", POSITIONS)
        self.refused("grow", "trees.glb", "--scene", "trees.glb",
                     options=("--scene", "MORPHOLOGY.csv"), kept="trees.glb")
        self.write("page.html", POSITIONS)
        self.refused("view", "page.html", "--no-open", options=("--out", "FILE"), kept="page.html")
        os.symlink("trees.glb", self.folder / "picture.png")
        done = subprocess.run([PROGRAM, "--version", "--json"], capture_output=True, text=True, check=True)
        if json.loads(done.stdout)["render"] is not None:
            self.refused("render", "trees.glb", "--out", "picture.png",
                         options=("--out", "MODEL.glb"), kept="trees.glb")

    def test_a_file_may_be_replaced_by_its_next_version(self):
        for _ in range(2):
            self.run_program("indices", "positions.csv", "--out", "i.csv", "--quiet")

    def test_open_files_may_be_named_as_often_as_one_likes(self):
        with_bad = POSITIONS + "1,99,SM,1,1,-5,8,3,2\n"
        self.write("bad.csv", with_bad)
        out = self.run_program("indices", "bad.csv", "--out", "/dev/fd/1", "--excluded", "/dev/fd/1",
                               "--quiet").stdout
        self.assertEqual(out.count("plot,tree,species,core"), 1)
        self.assertIn("99", out)


if __name__ == "__main__":
    unittest.main()
