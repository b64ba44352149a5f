# SPDX-License-Identifier: MIT
"""Unknown tables: how their columns are read, which rows are used, and columns that are made of others."""

import csv
import io
import json
import math
import unittest
from pathlib import Path

from silvafit_program import ProgramTest

WIDE = ("plot,tree,genus,epithet,x,y,DBH_2019,DBH_2024,H_2024\n"
        "1,1,Abies,alba,1,1,20,22.5,18\n"
        "1,2,Fagus,sylvatica,4,2,30,,\n"
        "1,3,Abies,alba,2,5,,11,8\n"
        "1,4,Abies,alba,5,5,14,15,12\n"
        "1,5,Fagus,sylvatica,3,3,40,41,24\n")


class Columns(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("wide.csv", WIDE)

    def rows_of(self, name):
        return list(csv.DictReader(io.StringIO((self.folder / name).read_text(encoding="utf-8"))))

    def test_an_unknown_table_is_shown(self):
        said = self.run_program("columns", "wide.csv").stdout
        self.assertIn("wide.csv: 5 rows", said)
        self.assertIn("dbh may be DBH_2019 or DBH_2024: --columns dbh=DBH_2019", said)
        self.assertIn("stand: lacks dbh", said)
        found = self.run_json("columns", "wide.csv", "--columns", "dbh=DBH_2019")
        self.assertEqual(found["schema"], "silvafit-columns/1")
        self.assertEqual(found["lacks"]["indices"], [])
        column = next(one for one in found["columns"] if one["column"] == "DBH_2019")
        self.assertEqual([column[key] for key in ("read_as", "unit", "missing", "lowest", "highest")],
                         ["dbh", "cm", 1, 14, 40])

    def test_an_error_names_the_columns_that_may_be_meant(self):
        said = self.run_program("stand", "wide.csv", status=3).stderr
        self.assertIn("it may be DBH_2019 or DBH_2024; name it with --columns dbh=DBH_2019", said)
        self.assertIn("`silvafit columns`", said)

    def test_the_same_rows_are_chosen_in_all_commands(self):
        chosen = "".join(line for line in WIDE.splitlines(keepends=True) if "Fagus" not in line)
        self.write("firs.csv", chosen)
        mapping = ("--columns", "dbh=DBH_2024,h=H_2024,species=genus,hcb=H_2024/2,cw=DBH_2024/5")
        where = ("--where", 'species == "Abies" && dbh > 0')
        for command in (("indices", "--edge", "none"), ("stand", "--plot-area", "100", "--json"),
                        ("grow", "--plain", "--scene", "stand.glb", "--json")):
            ours = self.run_program(command[0], "wide.csv", *command[1:], *mapping, *where)
            firs = self.run_program(command[0], "firs.csv", *command[1:], *mapping)
            if "--json" not in command:
                self.assertEqual(ours.stdout, firs.stdout)
                self.assertIn("3 of 5 rows are used, by the condition", ours.stderr)
                continue
            one, other = json.loads(ours.stdout), json.loads(firs.stdout)
            for result in (one, other):
                for key in ("inventory", "recognized", "notes", "seconds", "files", "left_out"):
                    result.pop(key, None)
            self.assertEqual(one, other, command)
        streamed = self.run_program("indices", "wide.csv", "--edge", "none", "--stream", *mapping, *where)
        self.assertEqual(streamed.stdout,
                         self.run_program("indices", "firs.csv", "--edge", "none", *mapping).stdout)
        self.assertIn("no row satisfies the condition",
                      self.run_program("stand", "wide.csv", *mapping, "--where", "dbh > 99", status=3).stderr)

    def test_files_with_new_columns_have_the_chosen_rows(self):
        lines = ["plot,tree,genus,dbh,h"]
        lines += [f"{i % 4},{i},{'Abies' if i % 5 else 'Larix'},{10 + i},{'' if i % 3 == 0 else 5 + 9 * math.log(10 + i) - 18}"
                  for i in range(80)]
        self.write("gaps.csv", "\n".join(lines) + "\n")
        self.run_program("impute", "gaps.csv", "--response", "h", "--where", 'species == "Abies"', "--columns",
                         'species=genus + ""', "--out", "filled.csv")
        filled = self.rows_of("filled.csv")
        self.assertEqual(len(filled), 64)
        self.assertEqual(list(filled[0])[:5], ["plot", "tree", "genus", "dbh", "h"])
        self.assertNotIn('genus + ""', filled[0])
        self.assertTrue(all(float(row["h"]) > 0 for row in filled))

    def test_visits_become_rows(self):
        growth = self.run_json("stand", "wide.csv", "--growth", "--plot-area", "100", "--visits",
                               "dbh=DBH_{year},h=H_{year}", "--columns", "species=genus")
        self.assertEqual(growth["trees"]["survivor"], 3)
        self.assertIn("rows of 2 times are made of the columns of year: 2019, 2024", growth["recognized"])
        # Trees 1, 4 and 5 were measured twice, in m2 per ha and year on 0.01 ha in 5 years.
        increment = math.pi / 4 * (22.5**2 - 20**2 + 15**2 - 14**2 + 41**2 - 40**2) / 1e4 / 0.01 / 5
        self.assertAlmostEqual(growth["plots"][0]["basal_area_m2"]["survivor_growth"], increment, places=12)
        refused = self.run_program("stand", "wide.csv", "--stream", "--visits", "dbh=DBH_{year}", status=2).stderr
        self.assertIn("omit --stream", refused)

    def test_a_study_file_chooses_rows(self):
        self.write("study.json", json.dumps({"where": "DBH_2024 > 20", "columns": {"dbh": "DBH_2024"}, "responses": ["h"]}))
        said = self.run_program("study", "wide.csv", "--config", "study.json", "--out", "out", status=4).stderr
        self.assertIn("2 of 5 rows are used, by the condition DBH_2024 > 20", said)

    def test_the_first_value_and_texts(self):
        said = self.run_program("indices", "wide.csv", "--edge", "none", "--columns",
                                'dbh=first(DBH_2024, DBH_2019),species=genus + " " + epithet').stdout
        rows = list(csv.DictReader(io.StringIO(said)))
        self.assertEqual([row["species"] for row in rows],
                         ["Abies alba", "Fagus sylvatica", "Abies alba", "Abies alba", "Fagus sylvatica"])
        self.run_program("stand", "wide.csv", "--columns", "dbh=first(DBH_2024, DBH_2019)/10", status=2)

    def test_circumferences_are_converted(self):
        self.write("girth.csv", "plot,tree,CBH\n1,1,31.41592653589793\n1,2,62.83185307179586\n")
        stand = self.run_json("stand", "girth.csv", "--plot-area", "100")
        # 10 and 20 cm across: pi/4 (0.1^2 + 0.2^2) m2 on 0.01 ha.
        self.assertIn("dbh is read from column CBH/pi (a circumference)", " ".join(stand["recognized"]))
        self.assertAlmostEqual(stand["all"]["basal_area_m2_per_ha"], math.pi / 4 * 0.05 / 0.01, places=9)


if __name__ == "__main__":
    unittest.main()
