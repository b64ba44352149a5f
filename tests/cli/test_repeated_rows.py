# SPDX-License-Identifier: MIT
"""Several rows with one plot and tree mean the same in all commands (docs/inventory.md, Several rows of one tree)."""

import csv
import io
import json
import random
import unittest

from silvafit_program import ProgramTest

HEADER = "plot,tree,species,x,y,dbh,h,hcb,cw"


def rows_of_trees():
    """Three plots of 16 trees in a grid; no two trees have equal values."""
    generator = random.Random(7)
    rows = []
    for plot in ("01", "02", "03"):
        for tree in range(1, 17):
            dbh = generator.uniform(8, 40)
            h = 1.3 + dbh**2 / (1.5 + 0.19 * dbh) ** 2 * generator.uniform(0.95, 1.05)
            x, y = 3 * (tree % 4) + generator.random(), 3 * (tree // 4) + generator.random()
            rows.append(f"{plot},{tree},a,{x:.2f},{y:.2f},{dbh:.1f},{h:.1f},{h / 2:.1f},{dbh / 9:.1f}")
    return rows


class RepeatedRows(ProgramTest):
    def setUp(self):
        super().setUp()
        self.rows = rows_of_trees()
        self.put("once.csv", self.rows)
        # Line 50 copies line 3, line 51 line 21.
        self.put("copies.csv", [*self.rows, self.rows[1], self.rows[19]])

    def put(self, name, rows, header=HEADER):
        self.write(name, "\n".join([header, *rows]) + "\n")

    def table(self, text):
        return list(csv.DictReader(io.StringIO(text)))

    def grown(self, name, *arguments):
        done = self.run_program("grow", name, "--out", "trees", "--json", "--lod", "3", *arguments)
        return [tree["tree"] for tree in json.loads(done.stdout)["trees"]], done.stderr

    def test_a_copy_counts_once_in_all_commands(self):
        fit = ("--model", "M4", "--random", "a | plot", "--json")
        once = self.run_json("fit", "once.csv", *fit)
        done = self.run_program("fit", "copies.csv", *fit)
        found = json.loads(done.stdout)
        self.assertEqual(found["n"], 48)
        self.assertEqual(found["fixed"], once["fixed"])
        self.assertIn("2 rows are copies of an earlier row of the same plot and tree and used once, the first: "
                      "copies.csv:50: copy of line 3 (plot 01, tree 2)", done.stderr)
        self.write("fit.json", json.dumps(once))

        for command in (("predict", "fit.json", "{}", "--level", "calibrated", "--seen-groups", "new"),
                        ("impute", "{}", "--response", "hcb")):
            left_out = [row.rsplit(",", 2)[0] + ",," if i % 5 == 0 else row for i, row in enumerate(self.rows)]
            self.put("gaps.csv", left_out)
            self.put("gaps_copies.csv", [*left_out, left_out[5], left_out[19]])
            before = self.table(self.run_program(*(part.format("gaps.csv") for part in command)).stdout)
            after = self.table(self.run_program(*(part.format("gaps_copies.csv") for part in command)).stdout)
            # Each row of the file has its values, a copy those of its original.
            self.assertEqual(after, [*before, before[5], before[19]])

        for command in ("indices", "stand"):
            before = self.run_program(command, "once.csv")
            after = self.run_program(command, "copies.csv")
            self.assertEqual(before.stdout, after.stdout)
            self.assertIn("copies.csv:50: tree: the same tree is on line 3 (plot 01, tree 2)", after.stderr)
        trees, notes = self.grown("copies.csv")
        self.assertEqual(len(trees), 48)
        self.assertIn("note: 2 rows repeat trees and are skipped, the first: copies.csv:50: the same tree is on line 3 "
                      "(plot 01, tree 2)", notes)

    def test_another_tree_of_the_same_number_is_used_in_all_commands(self):
        other = "01,2,a,20.5,3.5,33.3,24.4,11.1,3.3"
        self.put("other.csv", [*self.rows, other])
        done = self.run_program("fit", "other.csv", "--model", "M4", "--json")
        self.assertEqual(json.loads(done.stdout)["n"], 49)
        self.assertIn("1 row has the plot and tree of another row with other values; each is an observation",
                      done.stderr)
        done = self.run_program("indices", "other.csv")
        self.assertEqual([row["tree"] for row in self.table(done.stdout)][-1], "2#2")
        trees, notes = self.grown("other.csv")
        self.assertEqual(trees[-1], "2#2")
        self.assertIn("1 tree has the number of another tree of the same plot and got a new one, the first: "
                      "other.csv:50: now 2#2 (plot 01, tree 2)", notes)

    def test_a_later_measurement_is_an_observation_and_no_other_tree(self):
        early = [row + ",2010" for row in self.rows]
        later = [",".join([*row.split(",")[:5], f"{float(row.split(',')[5]) + 4:.1f}", *row.split(",")[6:], "2020"])
                 for row in self.rows]
        header = HEADER + ",year"
        self.put("later.csv", later, header)
        self.put("both.csv", [*early, *later, later[3]], header)
        done = self.run_program("fit", "both.csv", "--model", "M4", "--json")
        self.assertEqual(json.loads(done.stdout)["n"], 96)
        self.assertNotIn("each is an observation", done.stderr)
        self.assertIn("1 row is a copy of an earlier row", done.stderr)
        self.assertEqual(self.run_program("indices", "later.csv").stdout, self.run_program("indices", "both.csv").stdout)
        trees, notes = self.grown("both.csv")
        self.assertEqual(len(trees), 48)
        self.assertIn("note: 3 plots were measured several times: the last visit is used (plot 01: 2020), 48 rows of "
                      "earlier ones are skipped; --where chooses another time", notes)
        self.assertIn("note: 1 row repeats a tree and is skipped, the first: both.csv:98: the same tree is on line 53 "
                      "(plot 01, tree 4)", notes)

    def test_rows_of_sums_are_no_trees_in_all_commands(self):
        sums = ["Mean,,,,,24.1,17.3,8.2,3.1", ",,Total,,,900.5,80.1,40.2,20.3"]
        self.put("sums.csv", [*self.rows, *sums])
        said = "2 rows are of sums or means and are {}, the first: sums.csv:50: plot: Mean"
        fit = ("--model", "M4", "--json")
        done = self.run_program("fit", "sums.csv", *fit)
        self.assertEqual(json.loads(done.stdout)["fixed"], self.run_json("fit", "once.csv", *fit)["fixed"])
        self.assertIn(said.format("skipped"), done.stderr)
        trees, notes = self.grown("sums.csv")
        self.assertEqual(len(trees), 48)
        self.assertIn(said.format("skipped"), notes)
        done = self.run_program("stand", "sums.csv")
        self.assertEqual(done.stdout, self.run_program("stand", "once.csv").stdout)
        self.assertIn("a row of sums or means is not a tree", done.stderr)

        gaps = [row if i % 5 else ",".join([*row.split(",")[:6], "", *row.split(",")[7:]])
                for i, row in enumerate(self.rows)]
        self.put("sums.csv", [*gaps, *sums])
        self.put("gaps.csv", gaps)
        impute = ("--response", "h")
        done = self.run_program("impute", "sums.csv", *impute)
        self.assertIn(said.format("neither used nor filled in"), done.stderr)
        rows = self.table(done.stdout)
        self.assertEqual(rows[:48], self.table(self.run_program("impute", "gaps.csv", *impute).stdout))
        self.assertEqual([row["h_flag"] for row in rows[48:]], ["no living tree"] * 2)

    def test_labels_are_compared_as_text(self):
        self.put("labels.csv", [*self.rows, *(row.replace("01,", "1,", 1) for row in self.rows[:16])])
        similar = "'01' and '1'"
        for command in (("fit", "labels.csv", "--model", "M4", "--random", "a | plot"), ("indices", "labels.csv"),
                        ("stand", "labels.csv"), ("impute", "labels.csv", "--response", "h"),
                        ("grow", "labels.csv", "--plot", "1", "--lod", "3", "--out", "trees")):
            notes = self.run_program(*command).stderr
            self.assertIn(similar, notes, command[0])
            self.assertNotIn("skipped", notes, command[0])
            self.assertNotIn("cop", notes.replace("copies.csv", ""), command[0])


if __name__ == "__main__":
    unittest.main()
