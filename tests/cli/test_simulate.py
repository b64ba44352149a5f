# SPDX-License-Identifier: MIT
"""Simulated inventories: what is written, and what is said of it."""

import collections
import csv
import json
import unittest
from pathlib import Path

from silvafit_program import ProgramTest

DESIGN = str(Path(__file__).parents[2] / "examples" / "fir-mixed" / "design.json")


class Simulate(ProgramTest):
    def species_of(self, name):
        with open(self.folder / name, encoding="utf-8", newline="") as file:
            return collections.Counter(row["species"] for row in csv.DictReader(file))

    def test_the_summary_counts_what_is_written(self):
        summary = self.run_json("simulate", DESIGN, "--out", "stand.csv", "--truth", "truth.json", "--seed", "5")
        self.assertEqual(summary["schema"], "silvafit-simulation/1")
        self.assertEqual(summary["seed"], 5)
        written = self.species_of("stand.csv")
        self.assertEqual(summary["species"], dict(written))
        self.assertEqual(summary["trees"], written.total())
        truth = json.loads((self.folder / "truth.json").read_text(encoding="utf-8"))
        self.assertEqual(truth["seed"], 5)

    def test_the_table_counts_the_same(self):
        said = self.run_program("simulate", DESIGN, "--out", "stand.csv", "--quiet").stdout.split()
        self.assertEqual(said[:2], ["species", "trees"])
        counts = {name: int(trees) for name, trees in zip(said[2::2], said[3::2], strict=True)}
        self.assertEqual(counts, dict(self.species_of("stand.csv")))


if __name__ == "__main__":
    unittest.main()
