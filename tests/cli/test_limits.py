# SPDX-License-Identifier: MIT
"""Inputs that ask for endless or very much work end soon, with a result or with a remedy."""

import json
import math
import random
import unittest
from pathlib import Path

from silvafit_program import ProgramTest

DESIGN = Path(__file__).parents[2] / "examples" / "fir-mixed" / "design.json"


def csv_of(header, rows):
    return "\n".join([header, *(",".join(str(value) for value in row) for row in rows)]) + "\n"


class Limits(ProgramTest):
    def refused(self, *arguments, status=3):
        """The message of an input that is refused."""
        return self.run_program(*arguments, "--quiet", status=status).stderr

    def test_diameters_that_hardly_vary(self):
        design = json.loads(DESIGN.read_text(encoding="utf-8"))
        for share in (1e-9, 1e-200):
            for species in design["species"]:
                species["dbh"]["sd"] = share * species["dbh"]["mean"]
                species["dbh"]["plot_log_sd"] = 0
                species["density"] = 50
            self.write("design.json", json.dumps(design))
            self.run_program("simulate", "design.json", "--out", "stand.csv", "--quiet")
            rows = (self.folder / "stand.csv").read_text(encoding="utf-8").splitlines()
            column = rows[0].split(",").index("dbh")
            means = {species["code"]: species["dbh"]["mean"] for species in design["species"]}
            code = rows[0].split(",").index("species")
            for row in rows[1:]:
                fields = row.split(",")
                self.assertAlmostEqual(float(fields[column]), means[fields[code]], delta=0.051)

    def test_trees_of_extreme_numbers(self):
        """A tree that cannot exist is named and skipped, and the others are drawn as without it."""
        names = ("plot", "tree", "species", "x", "y", "z", "dbh", "h", "hcb", "cw")
        extreme = (1, 1, "SM", 0, 0, 0, 25, 18, 7, 4)
        tree = (1, 2, "SM", 5, 3, 0, 25, 18, 7, 4)
        self.write("one.csv", csv_of(",".join(names), [tree]))
        grow = ("--lod", "3", "--plain")
        self.run_program("grow", "one.csv", "--scene", "one.glb", *grow, "--quiet")
        scene = (self.folder / "one.glb").read_bytes()
        for name in names[3:]:
            for value in ("1e300", "-1e300", "1e30"):
                row = [value if other == name else old for other, old in zip(names, extreme)]
                self.write("trees.csv", csv_of(",".join(names), [row, tree]))
                done = self.run_program("grow", "trees.csv", "--scene", "trees.glb", "--trust-units", *grow)
                self.assertIn(f"trees.csv:2: {name}: ", done.stderr)
                self.assertTrue((self.folder / "trees.glb").read_bytes() == scene)

    def test_a_design_without_room(self):
        design = json.loads(DESIGN.read_text(encoding="utf-8"))
        for species in design["species"]:
            species["patchiness"] = 30
        self.write("design.json", json.dumps(design))
        self.assertIn("patchiness", self.refused("simulate", "design.json", "--out", "stand.csv"))

    def test_more_coefficients_than_rows(self):
        draw = random.Random(1)
        rows = [(f"g{i % 20}", f"k{i // 20}", round(draw.uniform(5, 50), 1), 20) for i in range(350)]
        self.write("data.csv", csv_of("g,k,dbh,h", rows))
        message = self.refused("fit", "data.csv", "--formula", "h ~ a + b*dbh",
                               "--parameter", "b ~ g*k")
        self.assertIn("need at least as many rows", message)
        self.assertIn("--random", message)

    def test_too_many_strata(self):
        draw = random.Random(2)
        rows = [(i // 5, i, round(draw.uniform(5, 50), 1), round(draw.uniform(5, 30), 1))
                for i in range(4000)]
        self.write("data.csv", csv_of("plot,tree,dbh,h", rows))
        for variance, count in (("stratum(plot)", 800), ("power(dbh | tree)", 4000)):
            message = self.refused("fit", "data.csv", "--formula", "h ~ a + b*dbh",
                                   "--variance", variance)
            self.assertIn(f"has {count} values", message)

    def test_a_tree_amid_a_circle_of_ties(self):
        count = 20000
        rows = [(i, round(100 * math.cos(2 * math.pi * i / count), 10),
                 round(100 * math.sin(2 * math.pi * i / count), 10), 20) for i in range(count)]
        self.write("circle.csv", csv_of("tree,x,y,dbh", [("center", 0, 0, 20), *rows]))
        found = self.run_program("indices", "circle.csv", "--edge", "none", "--quiet").stdout
        header, center = (line.split(",") for line in found.splitlines()[:2])
        # Of all ties, those with the smallest numbers.
        nearest = [center[header.index(f"nn{i}")] for i in range(1, 5)]
        self.assertEqual(nearest, ["0", "1", "2", "3"])

    def test_competitors_in_a_wide_circle(self):
        draw = random.Random(3)
        rows = [(i, round(draw.uniform(0, 800), 2), round(draw.uniform(0, 800), 2), 20)
                for i in range(40000)]
        self.write("stand.csv", csv_of("tree,x,y,dbh", rows))
        message = self.refused("indices", "stand.csv", "--further", "Hegyi",
                               "--competition-radius", "1000", status=2)
        self.assertIn("--competition-radius: 1000 m gives more than 1e+09 pairs", message)

    def test_groups_of_one_tree(self):
        draw = random.Random(4)
        rows = []
        for i in range(300):
            dbh = draw.uniform(8, 45)
            h = 1.3 + 25 * (1 - math.exp(-0.05 * dbh)) + draw.gauss(0, 1)
            rows.append((1, i, "A", round(draw.uniform(0, 30), 3), round(draw.uniform(0, 30), 3),
                         round(dbh, 1), round(h, 2)))
        self.write("stand.csv", csv_of("plot,tree,species,x,y,dbh,h", rows))
        self.run_program("study", "stand.csv", "--out", "study", "--group", "x", "--quiet")
        library = (self.folder / "study" / "report.html").read_text(encoding="utf-8")
        self.assertIn("random effects need groups of several trees", library)

    def test_crowns_at_one_place(self):
        rows = [(1, i, "SM", 0, 0, 20, 18, 7, 4) for i in range(600)]
        self.write("trees.csv", csv_of("plot,tree,species,x,y,dbh,h,hcb,cw", rows))
        message = self.refused("grow", "trees.csv", "--scene", "stand.glb", "--resolve-overlaps")
        self.assertIn("omit --resolve-overlaps", message)

    def test_files_without_an_end(self):
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h,hcb,cw\n1,1,SM,0,0,20,18,7,4\n")
        for arguments in (
            ("simulate", "/dev/zero", "--out", "stand.csv"),
            ("indices", "trees.csv", "--window", "/dev/zero"),
            ("grow", "trees.csv", "--builder", "lsystem", "--grammar", "/dev/zero", "--scene", "s.glb"),
        ):
            self.assertIn("/dev/zero: is larger than", self.refused(*arguments))

    def test_pictures_that_take_days(self):
        if "not in this build" in self.run_program("--help").stdout:
            self.skipTest("built without Embree or libpng")
        message = self.refused("render", "stand.glb", "--out", "stand.png", "--size", "16384x16384",
                               "--samples", "65536", status=2)
        self.assertIn("reduce --size or --samples", message)


if __name__ == "__main__":
    unittest.main()
