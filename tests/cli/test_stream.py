# SPDX-License-Identifier: MIT
"""Files that are read in parts: the same bytes as in one piece, and memory that does not grow with the file."""

import functools
import json
import random
import subprocess
import unittest

from silvafit_program import PROGRAM, ProgramTest, stand_csv

MEYER = "h ~ 1.3 + a*(1 - exp(-b*dbh))"
# A part has 200,000 rows.
PLOTS, TREES = 2300, 90


@functools.cache
def many_trees(is_shuffled, plots=PLOTS, seed=5):
    """Trees of many plots, 5 % with heights; rows that cannot be used, copies, and codes for missing values."""
    draw = random.Random(seed)
    rows = []
    for plot in range(1, plots + 1):
        for tree in range(1, TREES + 1):
            species = draw.choice(["SM", "SM", "SM", "oak, red"])
            dbh = round(draw.uniform(6, 50), 1)
            h = round(1.3 + 25 * (1 - 2.718281828 ** (-0.05 * dbh)) + draw.gauss(0, 0.5), 2)
            h = h if draw.random() < 0.05 else draw.choice(["", "", "NA", "-"])
            if draw.random() < 0.001:
                dbh = draw.choice(["", "-5", "thick"])
            rows.append([f"{plot:05d}", tree, f'"{species}"', round(draw.uniform(0, 30), 2), round(draw.uniform(0, 30), 2), dbh, h,
                         round(draw.uniform(1, 6), 1)])
    if is_shuffled:
        draw.shuffle(rows)
    lines = [",".join(map(str, row)) for row in rows]
    # Numbers until the last rows.
    notes = [f"{i % 7:02d}" for i in range(len(lines))]
    notes[-1] = '"a ""note"""'
    lines = [f"{line},{note}" for line, note in zip(lines, notes)]
    lines.insert(21, lines[20])  # a copy of a row
    return "plot,tree,species,x,y,dbh,h,cw,note\n" + "\n".join(lines) + "\n"


def without_dbh_texts(text):
    """Models need numbers in the columns that they read."""
    return text.replace(",thick,", ",NA,").replace(",-5,", ",NA,")


class Parts(ProgramTest):
    def compare(self, *arguments, out="out.csv"):
        """The result of both ways, and what the second one says."""
        one = self.run_program(*arguments, "--out", "one.csv")
        parts = self.run_program(*arguments, "--stream", "--out", "parts.csv")
        whole = (self.folder / "one.csv").read_bytes()
        self.assertGreater(len(whole), 1000)
        self.assertTrue(whole == (self.folder / "parts.csv").read_bytes(), "the bytes differ")
        return one.stderr, parts.stderr

    def test_indices_of_plots_in_any_order(self):
        self.write("trees.csv", many_trees(True))
        arguments = ["indices", "trees.csv", "--edge", "none"]
        whole = self.run_program(*arguments, "--out", "a.csv", "--excluded", "a_x.csv")
        parts = self.run_program(*arguments, "--stream", "--out", "b.csv", "--excluded", "b_x.csv")
        for name in ("{}.csv", "{}_x.csv"):
            one = (self.folder / name.format("a")).read_bytes()
            self.assertTrue(one == (self.folder / name.format("b")).read_bytes(), name)
        self.assertIn("sorted by plot on disk", parts.stderr)
        self.assertNotIn("sorted", whole.stderr)

    def compare_stands(self, *options):
        """Tables, units, JSON and text of a stand, both ways. Returns the notes of the second one."""
        texts, values, notes = [], [], []
        for folder, stream in (("whole", []), ("parts", ["--stream"])):
            arguments = ["stand", "trees.csv", *options, "--out", folder, *stream]
            texts.append(self.run_program(*arguments).stdout)
            values.append(self.run_json(*arguments))
            del values[-1]["seconds"]
            notes.append([note for note in values[-1].pop("notes")])
        self.assertEqual(texts[0], texts[1])
        self.assertEqual(values[0], values[1])
        names = sorted(path.name for path in (self.folder / "whole").iterdir())
        self.assertEqual(names, sorted(path.name for path in (self.folder / "parts").iterdir()))
        for name in names:
            whole, parts = ((self.folder / folder / name).read_bytes() for folder in ("whole", "parts"))
            self.assertTrue(whole == parts, name)
        self.assertEqual(notes[0], [note for note in notes[1] if "sorted by plot on disk" not in note])
        return "\n".join(notes[1])

    def test_stands_of_plots_in_any_order(self):
        """Sums have the same last digits, and the dominant heights are those of the thickest trees of all parts."""
        text = many_trees(False).replace("thick", "-1")
        lines = text.splitlines()
        # A plot with a window has no rows, the first row of plot 2 cannot be used, a species comes late.
        header, rows = lines[0] + ",stratum", [line.split(",") for line in lines[1:]]
        for number, row in enumerate(lines[1:]):
            plot = int(row[:5])
            late = row.replace(",SM,", ",elm,", 1) if plot == PLOTS and number % 5 == 0 else row
            rows[number] = f"{late},{'north' if plot % 3 else 'south'}"
        rows[TREES + 1] = rows[TREES + 1].replace(",1,", ",1,", 1).replace("SM", "SM")
        window = {"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"plot": plot}, "geometry": {"type": "Polygon", "coordinates": [
                [[0, 0], [30, 0], [30, 29], [0, 29], [0, 0]]]}} for plot in ("*", "empty")]}
        self.write("window.geojson", json.dumps(window))
        self.write("trees.csv", "\n".join([header, *rows]) + "\n")
        strata = ("--stratum", "stratum", "--stratum-area", "north=3000,south=900.5")
        for stream in ([], ["--stream"]):
            done = self.run_program("stand", "trees.csv", "--window", "window.geojson", *strata, *stream, status=3)
            self.assertIn("the plot has no living tree that tells its stratum by the column stratum", done.stderr)
        self.write("every.geojson", json.dumps({**window, "features": window["features"][:1]}))
        self.compare_stands("--window", "every.geojson", "--edge", "hanisch", "--neighbors", "5", "--further", "CO,T", *strata)
        random.Random(3).shuffle(rows)
        self.write("trees.csv", "\n".join([header, *rows]) + "\n")
        says = self.compare_stands("--window", "window.geojson", "--edge", "hanisch", "--neighbors", "5", "--further", "CO,T")
        self.assertIn("sorted by plot on disk", says)
        self.assertIn("they are counted as empty" if "they are" in says else "it is counted as empty", says)

    def test_what_stands_in_parts_refuse(self):
        self.write("trees.csv", many_trees(False, plots=2))
        for options, why in ((["--per", "stand"], "--per plot"), (["--growth"], "omit --stream or --growth"),
                             (["--angle-count", "2"], "sampling design")):
            self.assertIn(why, self.run_program("stand", "trees.csv", "--stream", *options, status=2).stderr)

    def test_a_stand_of_one_plot_in_parts(self):
        """Its quadrats are squares of 10 m in both ways, and its volumes have the same notes."""
        self.write("trees.csv", many_trees(False, plots=1))
        says = self.compare_stands("--equations", "taper", "--edge", "none")
        self.assertIn("no volume", says)

    def test_predictions(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", MEYER, "--random", "a | plot")
        self.write("fit.json", json.dumps(fit))
        self.write("trees.csv", without_dbh_texts(many_trees(True)))
        _, says = self.compare("predict", "fit.json", "trees.csv", "--interval", "0.9")
        self.assertNotIn("sorted", says, "rows are independent")
        _, says = self.compare("predict", "fit.json", "trees.csv", "--level", "calibrated", "--standard-errors")
        self.assertIn("sorted by plot on disk", says)
        self.write("trees.csv", without_dbh_texts(many_trees(False)))
        _, says = self.compare("predict", "fit.json", "trees.csv", "--level", "calibrated")
        self.assertNotIn("sorted", says)
        whole = self.run_json("predict", "fit.json", "trees.csv", "--level", "calibrated")
        parts = self.run_json("predict", "fit.json", "trees.csv", "--level", "calibrated", "--stream")
        self.assertEqual(whole, parts)

    def test_imputation(self):
        self.write("trees.csv", without_dbh_texts(many_trees(True)))
        arguments = ["impute", "trees.csv", "--by", "species", "--random", "a | plot"]
        whole, parts = self.compare(*arguments)
        said = "the rows of a plot are not contiguous"
        self.assertEqual(whole.splitlines()[-3:], parts.splitlines()[-3:])
        self.assertIn(said, parts)
        refused = self.run_program(*arguments, "--stream", "--add-residual", status=2)
        self.assertIn("--add-residual", refused.stderr)

    def test_what_cannot_be_read_twice_is_refused(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", MEYER, "--random", "a | plot")
        self.write("fit.json", json.dumps(fit))
        done = subprocess.run([PROGRAM, "predict", "fit.json", "/dev/stdin", "--stream"], cwd=self.folder, text=True,
                              input="plot,tree,dbh\n1,1,20\n", capture_output=True, check=False)
        self.assertEqual(done.returncode, 3)
        self.assertIn("give a file", done.stderr)

    def test_a_file_without_rows_has_a_header_only(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", MEYER)
        self.write("fit.json", json.dumps(fit))
        self.write("empty.csv", "plot,tree,dbh\n")
        self.assertEqual(self.run_program("predict", "fit.json", "empty.csv", "--stream").stdout,
                         self.run_program("predict", "fit.json", "empty.csv").stdout)

    def test_memory_does_not_grow_with_the_file(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", MEYER, "--random", "a | plot")
        self.write("fit.json", json.dumps(fit))

        def peak_kib(rows):
            lines = (f"{i // 20},{i},SM,{10 + i % 40}" for i in range(rows))
            self.write("rows.csv", "plot,tree,species,dbh\n" + "\n".join(lines) + "\n")
            script = ("import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); "
                      "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
            done = subprocess.run(["python3", "-c", script, PROGRAM, "predict", "fit.json", "rows.csv", "--stream",
                                   "--level", "calibrated", "--out", "out.csv"],
                                  cwd=self.folder, capture_output=True, text=True, check=True)
            return int(done.stdout.split()[-1])

        # In one piece, 800,000 more rows take 300 MB.
        self.assertLess(peak_kib(1200000) - peak_kib(400000), 60 * 1024)


if __name__ == "__main__":
    unittest.main()
