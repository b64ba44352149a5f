# SPDX-License-Identifier: MIT
"""The same input, seed and options give the same bytes, for any number of threads.

SILVAFIT_OTHER_PROGRAM, if it is set, is another build of the program: its bytes are compared, too.
"""

import hashlib
import json
import os
import re
import subprocess
import unittest
from pathlib import Path

from silvafit_program import PROGRAM, ProgramTest

ROOT = Path(__file__).parents[2]
EXAMPLE = str(ROOT / "examples" / "fir-mixed" / "inventory.csv")
DESIGN = str(ROOT / "examples" / "fir-mixed" / "design.json")
BAMBOO = str(ROOT / "examples" / "bamboo" / "stand.csv")
OTHER = os.environ.get("SILVAFIT_OTHER_PROGRAM")

# How long something took is no result, and the report names the command that made it.
TIMES = re.compile(rb'"seconds": ?[-+.e0-9]+|\d+\.\d+ s\b|\d+ a second|--threads \d+')


def digest(path):
    return hashlib.sha256(TIMES.sub(b"", path.read_bytes())).hexdigest()


class Reproducible(ProgramTest):
    def outputs(self, program, threads, name, arguments):
        """Digests of all files that a command writes, and of its standard output."""
        folder = self.folder / name
        folder.mkdir()
        done = subprocess.run([program, *arguments, "--threads", str(threads)], cwd=folder, capture_output=True,
                              timeout=280, check=False)
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        (folder / "standard-output").write_bytes(done.stdout)
        # run.json holds times and the number of threads.
        return {str(path.relative_to(folder)): digest(path) for path in folder.rglob("*")
                if path.is_file() and path.name != "run.json"}

    def assert_same_bytes(self, *arguments):
        expected = self.outputs(PROGRAM, 1, "threads-1", arguments)
        self.assertTrue(expected)
        for threads in (2, 8):
            self.assertEqual(self.outputs(PROGRAM, threads, f"threads-{threads}", arguments), expected, arguments)
        if OTHER:
            self.assertEqual(self.outputs(OTHER, 2, "other", arguments), expected, arguments)

    def test_study(self):
        self.assert_same_bytes("study", EXAMPLE, "--species", "SM", "--responses", "h,cw", "--out", "study")

    def test_cross_validation(self):
        self.assert_same_bytes("study", EXAMPLE, "--species", "SM", "--responses", "h", "--criterion", "cv", "--out", "study")

    def test_bootstrap(self):
        self.assert_same_bytes("fit", EXAMPLE, "--model", "M4", "--where", 'species == "SM"', "--random", "a | plot",
                               "--bootstrap", "10", "--json")

    def test_indices(self):
        self.assert_same_bytes("indices", EXAMPLE, "--out", "indices.csv")

    def test_impute(self):
        self.assert_same_bytes("impute", EXAMPLE, "--response", "h", "--add-residual", "--seed", "3", "--out", "imputed.csv")

    def test_simulate(self):
        self.assert_same_bytes("simulate", DESIGN, "--out", "simulated")

    def test_trees_of_every_builder(self):
        for number, builder in enumerate(("segment", "lsystem", "ifs")):
            with self.subTest(builder=builder):
                self.folder = self.folder.parent / f"{self.folder.name}-{number}"
                self.folder.mkdir()
                self.addCleanup(subprocess.run, ["rm", "-rf", str(self.folder)], check=False)
                self.assert_same_bytes("grow", BAMBOO, "--builder", builder, "--lod", "3", "--resolve-overlaps",
                                       "--scene", "stand.glb", "--quiet")

    def test_bamboo(self):
        self.assert_same_bytes("grow", BAMBOO, "--builder", "bamboo", "--lod", "2", "--scene", "stand.glb",
                               "--quiet")

    def test_page_in_3d(self):
        self.assert_same_bytes("view", EXAMPLE, "--plot", "1", "--out", "stand.html", "--no-open", "--quiet")

    def test_picture(self):
        trees = str(ROOT / "examples" / "segment-trees" / "tree-1.csv")
        self.run_program("grow", trees, "--scene", "tree.glb", "--quiet")
        self.assert_same_bytes("render", str(self.folder / "tree.glb"), "--out", "tree.png", "--size", "200x200", "--quiet")


if __name__ == "__main__":
    unittest.main()
