# SPDX-License-Identifier: MIT
"""Tiles: the bytes of one run over the whole inventory, from any order of tiles, broken ones, and small halos."""

import csv
import io
import json
import math
import random
import subprocess
import unittest

from silvafit_program import PROGRAM, ProgramTest, stand_csv

MEYER = "h ~ 1.3 + a*(1 - exp(-b*dbh))"


def forest(trees=3000, side=400.0, seed=7, plots=1):
    """A forest with a dense corner, a gap, stems at one position, and rows without a position."""
    draw = random.Random(seed)
    lines = ["stand,tree,species,x,y,dbh,cw,height m,note"]
    for tree in range(1, trees + 1):
        while True:
            x, y = draw.uniform(0, side), draw.uniform(0, side)
            if math.hypot(x - 0.6 * side, y - 0.6 * side) > side / 10:
                break
        if tree % 3 == 0:
            x, y = draw.uniform(0, side / 4), draw.uniform(0, side / 4)
        x, y = round(x + 500000, 1), round(y + 4000000, 1)
        species = draw.choice(["fir", "oak", "oak, red"])
        dbh, cw = round(draw.uniform(6, 60), 1), round(draw.uniform(2, 9), 1)
        if tree % 97 == 0:
            x = ""
        if tree % 50 == 0:
            dbh = ""
        lines.append(f'{tree % plots + 1},{tree},"{species}",{x},{y},{dbh},{cw},,"n\n{tree}"')
    return "\n".join(lines) + "\n"


class Tiles(ProgramTest):
    columns = ("--columns", "plot=stand")

    def plan(self, name="trees.csv", size="100", halo="60", folder="tiles"):
        return self.run_json("tiles", "plan", name, "--size", size, "--halo", halo, "--out", folder, *self.columns)

    def run_all(self, *command, order=1, folder="tiles"):
        count = len(json.loads((self.folder / folder / "plan.json").read_text())["tiles"])
        for tile in list(range(1, count + 1))[::order]:
            self.run_program("tiles", "run", folder, "--tile", str(tile), "--", *command)

    def merged(self, command="indices"):
        done = self.run_program("tiles", "merge", "tiles", command, "--out", "merged.csv")
        self.assertNotIn("halo", done.stderr)
        return (self.folder / "merged.csv").read_bytes()

    def whole(self, command, *options, before=()):
        self.run_program(command, *before, "trees.csv", *self.columns, *options, "--out", "whole.csv")
        return (self.folder / "whole.csv").read_bytes()

    def test_indices_are_those_of_the_whole_inventory(self):
        self.write("trees.csv", forest())
        self.write("window.wkt", "POLYGON((500000 4000000, 500400 4000000, 500400 4000200, 500200 4000400, "
                                 "500000 4000400, 500000 4000000))\n")
        self.plan()
        for options in (["--edge", "none"],
                        [],  # the convex hull and a buffer
                        ["--buffer", "12", "--window", "window.wkt"],
                        ["--neighbors", "6", "--alpha", "oak=50", "--further", "CO,T,Hegyi", "--competition-radius", "8",
                         "--window", "window.wkt"]):
            with self.subTest(options):
                self.run_all("indices", *options, order=-1)
                whole, tiled = self.whole("indices", *options), self.merged()
                self.assertGreater(len(whole), 100000)
                self.assertTrue(whole == tiled, "the bytes differ")

    def test_chosen_rows_are_those_of_the_whole_inventory(self):
        self.write("trees.csv", forest())
        self.columns = (*self.columns, "--where", 'species != "oak" && dbh > 10')
        plan = self.plan()
        self.run_all("indices")
        whole, tiled = self.whole("indices"), self.merged()
        self.assertGreater(len(whole), 50000)
        self.assertTrue(whole == tiled, "the bytes differ")
        rows = list(csv.DictReader(io.StringIO(forest())))
        chosen = sum(row["species"] != "oak" and row["dbh"] != "" and float(row["dbh"]) > 10 for row in rows)
        self.assertEqual(plan["rows"], chosen)

    def test_trees_of_several_plots_are_neighbors_per_stand(self):
        self.write("trees.csv", forest(trees=1500, plots=3).replace(",7,", ",8,", 0))
        self.plan()
        refused = self.run_program("tiles", "run", "tiles", "--tile", "1", "--", "indices", status=2)
        self.assertIn("--per stand", refused.stderr)
        self.run_all("indices", "--per", "stand", "--edge", "none")
        self.assertTrue(self.whole("indices", "--per", "stand", "--edge", "none") == self.merged())

    def test_ids_that_repeat_between_plots_name_the_plot(self):
        rows = [f"{plot},{tree},fir,{10 * tree},{10 * plot + 5 * (tree % 2)},20" for plot in range(1, 21) for tree in range(1, 21)]
        self.write("trees.csv", "stand,tree,species,x,y,dbh\n" + "\n".join(rows) + "\n")
        self.plan(size="50", halo="40")
        self.run_all("indices", "--per", "stand", "--edge", "none")
        whole = self.whole("indices", "--per", "stand", "--edge", "none")
        self.assertIn(b"2-3", whole)
        self.assertTrue(whole == self.merged())

    def test_indices_are_those_of_their_definition(self):
        """W, M, U, C and T of all trees from all pairs of trees."""
        draw = random.Random(11)
        trees = [(i, draw.uniform(0, 200), draw.uniform(0, 200), draw.uniform(6, 60), draw.uniform(2, 9),
                  draw.choice("AB")) for i in range(400)]
        self.write("trees.csv", "tree,x,y,dbh,cw,species\n" +
                   "".join(f"{i},{x!r},{y!r},{d!r},{c!r},{s}\n" for i, x, y, d, c, s in trees))
        self.run_json("tiles", "plan", "trees.csv", "--size", "50", "--halo", "60", "--out", "tiles")
        self.run_all("indices", "--edge", "none", "--further", "T")
        rows = list(csv.DictReader(io.StringIO(self.merged().decode())))
        self.assertEqual(len(rows), len(trees))
        for row, (i, x, y, d, c, s) in zip(rows, trees):
            near = sorted((math.hypot(o[1] - x, o[2] - y), o) for o in trees if o[0] != i)[:4]
            azimuths = sorted(math.atan2(o[1] - x, o[2] - y) for _, o in near)
            angles = [(b - a) % (2 * math.pi) for a, b in zip(azimuths, azimuths[1:] + azimuths[:1])]
            angles = [min(a, 2 * math.pi - a) for a in angles]
            wanted = {"W": sum(a < math.radians(72) for a in angles) / 4,
                      "M": sum(o[5] != s for _, o in near) / 4,
                      "U": sum(o[3] >= d for _, o in near) / 4,
                      "C": sum((o[4] + c) / 2 > m for m, o in near) / 4,
                      "T": sum(1 - min(d, o[3]) / max(d, o[3]) for _, o in near) / 4}
            for name, value in wanted.items():
                # Sums of four numbers of size 1 in another order.
                self.assertAlmostEqual(float(row[name]), value, 12, (i, name))
            self.assertEqual([row[f"nn{k}"] for k in range(1, 5)], [str(o[0]) for _, o in near])

    def test_predictions_are_those_of_the_whole_inventory(self):
        self.write("trees.csv", forest())
        self.write("stand.csv", stand_csv())
        self.write("fit.json", json.dumps(self.run_json("fit", "stand.csv", "--formula", MEYER, "--random", "a | plot")))
        self.plan(halo="0")
        self.run_all("predict", "fit.json", "--interval", "0.9")
        whole = self.whole("predict", "--interval", "0.9", before=["fit.json"])
        self.assertTrue(whole == self.merged("predict"))
        self.assertEqual(len(list(csv.reader(io.StringIO(whole.decode())))), 3001)
        refused = self.run_program("tiles", "run", "tiles", "--tile", "1", "--", "predict", "fit.json", "--level",
                                   "calibrated", status=2)
        self.assertIn("--stream", refused.stderr)

    def test_a_tile_and_its_halo_may_be_without_dbh(self):
        """Positions of a region are mapped, and dbh is measured in another part of it."""
        head, *rows = forest().splitlines()
        without = []
        for row in csv.reader(io.StringIO("\n".join(rows))):
            if row[3] and float(row[3]) < 500280:
                row[5] = ""
            without.append(row)
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([head.split(","), *without])
        self.write("trees.csv", text.getvalue())
        self.plan(halo="60")
        self.run_all("indices", "--per", "stand", "--edge", "none")
        merged = self.merged()
        self.assertEqual(merged, self.whole("indices", "--per", "stand", "--edge", "none"))

    def test_scenes_have_the_trees_of_the_whole_inventory(self):
        draw = random.Random(5)
        rows = [f"1,{tree},{draw.choice(['fir', 'oak'])},{draw.uniform(0, 60):.1f},{draw.uniform(0, 60):.1f},{draw.uniform(8, 50):.1f},"
                f"{draw.uniform(14, 30):.1f},{draw.uniform(2, 9):.1f},{draw.uniform(2, 6):.1f}" for tree in range(1, 41)]
        # No tree of one tile can be grown.
        rows.append("1,41,fir,90.0,10.0,,20.0,3.0,4.0")
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h,hcb,cw\n" + "\n".join(rows) + "\n")
        self.run_program("tiles", "plan", "trees.csv", "--size", "30", "--halo", "5", "--out", "tiles")
        self.run_all("grow", "--lod", "3", "--plain")
        self.run_program("tiles", "merge", "tiles", "grow", "--out", "scenes.csv")
        scenes = list(csv.DictReader(io.StringIO((self.folder / "scenes.csv").read_text())))
        self.assertEqual(len(scenes), 4)
        self.assertEqual(sum(int(scene["trees"]) for scene in scenes), 40)
        whole = self.run_json("grow", "trees.csv", "--scene", "whole.glb", "--lod", "3", "--plain")
        # A tree has the same shape in both: its random numbers are those of its plot and number.
        self.assertEqual(sum(int(scene["triangles"]) for scene in scenes), whole["triangles"])
        first = json.loads(self.run_program("tiles", "run", "tiles", "--tile", "1", "--json", "--", "grow", "--lod", "3", "--plain").stdout)
        self.assertTrue(first["was_there"])
        self.run_program("tiles", "run", "tiles", "--tile", "1", "--", "grow", "--scene", "other.glb", status=2)

    def test_small_halos_mark_trees_and_are_never_wrong(self):
        self.write("trees.csv", forest())
        self.plan(halo="8")
        self.run_all("indices", "--edge", "none")
        done = self.run_program("tiles", "merge", "tiles", "--out", "merged.csv")
        self.assertRegex(done.stderr, r"too small for \d+ trees.*--halo \d+ is enough")
        enough = done.stderr.split("--halo ")[1].split()[0]
        with open(self.folder / "merged.csv", encoding="utf-8") as file:
            tiled = list(csv.DictReader(file))
        whole = list(csv.DictReader(io.StringIO(self.whole("indices", "--edge", "none").decode())))
        marked = 0
        for one, other in zip(tiled, whole, strict=True):
            mark = one.pop("halo")
            if mark:
                marked += 1
                self.assertEqual(mark, "too small")
                self.assertEqual((one["tree"], one["W"], one["nn1"]), (other["tree"], "", ""))
            else:
                self.assertEqual(one, other)
        self.assertGreater(marked, 20)
        self.assertLess(marked, 1500)
        # What the message says is enough.
        self.plan(halo=enough)
        self.run_all("indices", "--edge", "none")
        self.assertTrue(self.whole("indices", "--edge", "none") == self.merged())

    def test_what_is_missing_is_named_and_run_again(self):
        self.write("trees.csv", forest(trees=800))
        plan = self.plan()
        names = [tile["name"] for tile in plan["tiles"]]
        self.run_all("indices", "--edge", "none")
        (self.folder / "tiles" / "indices" / f"{names[2]}.csv").unlink()
        done = self.run_program("tiles", "merge", "tiles", "--out", "merged.csv", status=3)
        self.assertIn(f"1 tile has no result of indices: 3 ({names[2]})", done.stderr)
        self.assertFalse((self.folder / "merged.csv").exists())
        # A tile with other settings.
        self.run_program("tiles", "run", "tiles", "--tile", "3", "--", "indices", "--edge", "none", "--neighbors", "3")
        done = self.run_program("tiles", "merge", "tiles", "--out", "merged.csv", status=3)
        self.assertIn(f"3 ({names[2]})", done.stderr)
        self.assertIn("other settings", done.stderr)
        again = json.loads(self.run_program("tiles", "run", "tiles", "--tile", "3", "--json", "--", "indices", "--edge", "none").stdout)
        self.assertFalse(again["was_there"])
        again = json.loads(self.run_program("tiles", "run", "tiles", "--tile", "3", "--json", "--", "indices", "--edge", "none").stdout)
        self.assertTrue(again["was_there"])
        self.assertTrue(self.whole("indices", "--edge", "none") == self.merged())

    def test_results_that_were_changed_are_refused(self):
        self.write("trees.csv", forest(trees=500, side=200))
        names = [tile["name"] for tile in self.plan()["tiles"]]
        self.run_all("indices", "--edge", "none")
        path = self.folder / "tiles" / "indices" / f"{names[1]}.csv"
        text = path.read_text()
        lines = text.splitlines(keepends=True)
        changed = text.replace(",fir,", ",oak,", 1)
        for damaged in ("".join(lines[:-2]), "".join(lines[:3]), text[:-20], changed, text + lines[-1]):
            self.assertNotEqual(damaged, text)
            path.write_text(damaged)
            done = self.run_program("tiles", "merge", "tiles", "--out", "merged.csv", status=3)
            self.assertIn(names[1], done.stderr)
            self.assertFalse((self.folder / "merged.csv").exists())
        # The result of another tile.
        path.write_bytes((self.folder / "tiles" / "indices" / f"{names[0]}.csv").read_bytes())
        self.assertIn(names[1], self.run_program("tiles", "merge", "tiles", "--out", "merged.csv", status=3).stderr)
        path.write_text(text)
        self.assertTrue(self.whole("indices", "--edge", "none") == self.merged())
        # Trees of a tile that are not those of the plan.
        trees = self.folder / "tiles" / "tiles" / f"{names[0]}.csv"
        trees.write_text("".join(trees.read_text().splitlines(keepends=True)[:-1]))
        refused = self.run_program("tiles", "run", "tiles", "--tile", "1", "--", "indices", status=3).stderr
        self.assertIn(names[0], refused)

    def test_plans_that_were_changed_are_refused(self):
        self.write("trees.csv", forest(trees=200, side=200))
        self.plan()
        path = self.folder / "tiles" / "plan.json"
        text = path.read_text()
        plan = json.loads(text)
        damaged = [text[: len(text) * share // 10] for share in range(10)]
        for key in plan:
            for value in (None, -1, "x", [], {}, [None], 1e300):
                if value != plan[key]:
                    damaged.append(json.dumps({**plan, key: value}))
            damaged.append(json.dumps({other: plan[other] for other in plan if other != key}))
        for one in damaged:
            path.write_text(one)
            done = self.run_program("tiles", "run", "tiles", "--tile", "1", "--", "indices", status=3)
            self.assertIn("plan.json", done.stderr)
            self.assertNotIn("json.exception", done.stderr)

    def test_a_scene_that_was_removed_is_made_again(self):
        rows = [f"1,{tree},fir,{3 * tree},{tree},20,18,6,4" for tree in range(1, 9)]
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h,hcb,cw\n" + "\n".join(rows) + "\n")
        self.run_program("tiles", "plan", "trees.csv", "--size", "100", "--halo", "5", "--out", "tiles")
        run = ("tiles", "run", "tiles", "--tile", "1", "--", "grow", "--lod", "3", "--plain")
        self.run_program(*run)
        (scene,) = self.folder.glob("tiles/grow/*.glb")
        bytes_of_scene = scene.read_bytes()
        scene.unlink()
        self.assertIn("files were removed", self.run_program("tiles", "merge", "tiles", "grow", "--out", "scenes.csv", status=3).stderr)
        self.run_program(*run)
        self.assertTrue(scene.read_bytes() == bytes_of_scene)
        scene.write_bytes(bytes_of_scene[:-4])
        self.assertIn("is damaged", self.run_program("tiles", "merge", "tiles", "grow", "--out", "scenes.csv", status=3).stderr)

    def test_a_tile_that_is_killed_leaves_nothing(self):
        self.write("trees.csv", forest(trees=20000, side=300))
        self.run_json("tiles", "plan", "trees.csv", "--size", "1000", "--out", "tiles", *self.columns)
        words = [PROGRAM, "tiles", "run", "tiles", "--tile", "1", "--", "indices", "--edge", "none"]
        for wait in (0.01, 0.05, 0.1):
            process = subprocess.Popen(words, cwd=self.folder)
            try:
                process.wait(wait)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            results = list(self.folder.glob("tiles/indices/*.csv"))
            if results and process.returncode != 0:
                self.fail("a killed tile has a result")
        self.run_program(*words[1:])
        self.assertTrue(self.whole("indices", "--edge", "none") == self.merged())

    def test_inventories_that_tiles_would_change_are_refused(self):
        header = "plot,tree,species,x,y,dbh\n"
        for rows, text in (("1,1,fir,0,0,20\n1,1,fir,9,9,20\n", "line 2"),
                           ("1,1,fir,0,0,20\n1,2,Fir,9,9,20\n", "one spelling"),
                           ("1,1,fir,0,0,20\n1,2,fir,9e8,9,20\n", "--size")):
            self.write("odd.csv", header + rows)
            done = subprocess.run([PROGRAM, "tiles", "plan", "odd.csv", "--size", "0.1", "--halo", "1", "--out", "odd"], cwd=self.folder,
                                  capture_output=True, text=True, check=False)
            self.assertIn(done.returncode, (2, 3))
            self.assertIn(text, done.stderr)
            self.assertFalse((self.folder / "odd" / "plan.json").exists())
        self.write("odd.csv", "species,x,y,dbh\nfir,0,0,20\n")
        self.assertIn("numbers of trees", self.run_program("tiles", "plan", "odd.csv", "--out", "odd", status=3).stderr)
        self.write("trees.csv", forest(trees=300))
        self.plan()
        for options, text in ((["--edge", "torus"], "torus"), (["--edge", "hanisch"], "Hanisch"), (["--further", "BAL"], "BAL")):
            done = self.run_program("tiles", "run", "tiles", "--tile", "1", "--", "indices", *options, status=2)
            self.assertIn(text, done.stderr)
        self.assertIn("1 to", self.run_program("tiles", "run", "tiles", "--tile", "99", "--", "indices", status=2).stderr)


if __name__ == "__main__":
    unittest.main()
