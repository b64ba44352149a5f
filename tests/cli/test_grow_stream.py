# SPDX-License-Identifier: MIT
"""`silvafit grow` with files of plots, manifests, and tables that are read in parts."""

import csv
import random
import shutil
import unittest

from silvafit_program import ProgramTest

# A part has 20,000 rows.
PLOTS, TREES = 500, 45
COARSE = ["--plain", "--lod", "3", "--quantize"]


def trees(is_shuffled, plots=PLOTS):
    """Trees of many plots; some rows cannot be used, repeat a tree, or have its number."""
    draw = random.Random(7)
    rows = []
    for plot in range(1, plots + 1):
        for tree in range(1, TREES + 1):
            h = round(draw.uniform(6, 20), 1)
            rows.append(f"{plot:03d},{tree},{draw.choice(['SM', 'OF', 'XX'])},{draw.uniform(0, 30):.2f},"
                        f"{draw.uniform(0, 30):.2f},{draw.uniform(8, 30):.1f},{h if draw.random() > 0.001 else ''},{h / 3:.2f},"
                        f"{draw.uniform(1, 4):.2f}")
    # Of the first plot and of the last one: a copy, and another tree with its number.
    for number in (len(rows) - 3, 5):
        row = rows[number]
        plot, tree, species, x, y, *measures = row.split(",")
        rows[number + 1 : number + 1] = [row, ",".join([plot, tree, species, x, f"{float(y) + 7:.2f}", *measures])]
    if is_shuffled:
        draw.shuffle(rows)
    return "plot,tree,species,x,y,dbh,h,hcb,cw\n" + "\n".join(rows) + "\n"


class Streams(ProgramTest):
    def files_of(self, folder):
        return {path.name: path.read_bytes() for path in (self.folder / folder).iterdir()}

    def compare(self, *options):
        """Files and manifests of both ways; returns the messages of the second one."""
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        whole = self.run_program("grow", "trees.csv", *options, "--out", "out", "--manifest", "whole.csv")
        files = self.files_of("out")
        shutil.rmtree(self.folder / "out")
        parts = self.run_program("grow", "trees.csv", *options, "--out", "out", "--manifest", "parts.csv", "--stream")
        self.assertTrue(files == self.files_of("out"), "the bytes differ")
        self.assertEqual((self.folder / "whole.csv").read_text(), (self.folder / "parts.csv").read_text())
        self.assertEqual(whole.stdout.split(",")[0], parts.stdout.split(",")[0])
        # Which row is the first depends on their order; labels that differ little are not looked for in parts.
        said = [sorted(line.split(", the first:")[0] for line in text.splitlines()
                       if "sorted by plot on disk" not in line and "compared as text" not in line)
                for text in (whole.stderr.replace("; use --json to list them", ""), parts.stderr)]
        self.assertEqual(said[0], said[1])
        return files, parts.stderr

    def test_a_file_for_each_plot(self):
        for is_shuffled in (False, True):
            self.write("trees.csv", trees(is_shuffled))
            files, says = self.compare("--per", "plot", *COARSE)
            self.assertEqual(len(files), PLOTS)
            self.assertEqual("sorted by plot on disk" in says, is_shuffled)
            self.assertIn('No preset lists the species "OF", "XX"', says)
            self.assertIn("2 trees have the number of another tree", says)

    def test_a_file_for_each_tree(self):
        self.write("trees.csv", trees(True))
        files, _ = self.compare("--plot", "001,250,500", "--lod", "2,3", "--plain")
        with open(self.folder / "parts.csv", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        self.assertEqual({row["file"].removeprefix("out/") for row in rows}, set(files))
        self.assertEqual({int(row["bytes"]) for row in rows}, {len(data) for data in files.values()})
        self.assertEqual([row["level"] for row in rows[:2]], ["2", "3"])

    def test_the_file_of_a_plot_is_its_scene(self):
        """Overlaps are those within the plot; the ground and the origin are its own."""
        self.write("trees.csv", trees(False, plots=3))
        self.compare("--per", "plot", "--resolve-overlaps", "--ground", "flat", *COARSE)
        self.run_program("grow", "trees.csv", "--plot", "002", "--scene", "002.glb", "--resolve-overlaps", "--ground", "flat", *COARSE)
        self.assertTrue((self.folder / "002.glb").read_bytes() == (self.folder / "out" / "002.glb").read_bytes())
        result = self.run_json("grow", "trees.csv", "--per", "plot", "--out", "out", *COARSE)
        self.assertEqual([scene["file"] for scene in result["scenes"]], ["out/001.glb", "out/002.glb", "out/003.glb"])

    def test_names_that_differ_in_capitals_only_get_numbers(self):
        rows = [f"{plot},{tree},SM,{5 * tree},1,20,15,5,3" for plot in ("a", "A") for tree in (1, 2)]
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h,hcb,cw\n" + "\n".join(rows) + "\n")
        files, _ = self.compare("--per", "plot", *COARSE)
        self.assertEqual(set(files), {"a.glb", "A~2.glb"})
        files, _ = self.compare(*COARSE)
        self.assertEqual(set(files), {"a-1.glb", "a-2.glb", "A-1~2.glb", "A-2~2.glb"})

    def test_what_needs_all_trees_is_refused(self):
        self.write("trees.csv", trees(False, plots=1))
        for options, remedy in ((["--scene", "a.glb"], "--per plot"),
                                (["--out", "out", "--resolve-overlaps"], "add --per plot"),
                                (["--out", "out", "--by", "species"], "omit --stream or --by"),
                                (["--out", "out", "--json"], "--manifest")):
            self.assertIn(remedy, self.run_program("grow", "trees.csv", "--stream", *options, status=2).stderr)
        for options, remedy in ((["--scene", "a.glb", "--share", "--manifest", "m.csv"], "use --json"),
                                (["--out", "out", "--per", "plot", "--by", "species"], "omit")):
            self.assertIn(remedy, self.run_program("grow", "trees.csv", *options, status=2).stderr)
        self.write("trees.csv", "tree,dbh,h,hcb,cw\n1,20,15,5,3\n")
        refused = self.run_program("grow", "trees.csv", "--stream", "--out", "out", status=2)
        self.assertIn("omit --stream", refused.stderr)


if __name__ == "__main__":
    unittest.main()
