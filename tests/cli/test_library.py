# SPDX-License-Identifier: MIT
"""Libraries as other programs read them, and the scenes that are made of one."""

import csv
import io
import json
import math
import unittest
from pathlib import Path

try:
    import jsonschema
except ImportError:  # a Python that is not Debian's own
    jsonschema = None

from silvafit_program import ProgramTest, stand_csv

SOURCE = Path(__file__).parents[2]
MODELS = SOURCE / "models"
FORMULA = "h ~ 1.3 + a*(1 - exp(-b*dbh))"


def schema(name):
    return json.loads((MODELS / name).read_text(encoding="utf-8"))


def check_fit(fit):
    """A fit alone is what a library holds of each model."""
    of_fit = {**schema("library.schema.json"), **{"$ref": "#/definitions/fit"}}
    for key in ("type", "required", "properties"):
        of_fit.pop(key)
    jsonschema.Draft7Validator(of_fit).validate(fit)


needs_jsonschema = unittest.skipUnless(jsonschema, "this Python has no module jsonschema")


@needs_jsonschema
class Schemas(ProgramTest):
    def test_shipped_models_obey_their_schemas(self):
        for folder, name in (("published", "published.schema.json"), ("base", "base.schema.json")):
            validator = jsonschema.Draft7Validator(schema(name))
            files = sorted((MODELS / folder).glob("*.json"))
            self.assertTrue(files)
            for file in files:
                with self.subTest(file=file.name):
                    validator.validate(json.loads(file.read_text(encoding="utf-8")))

    def test_fits_of_every_kind_obey_the_schema(self):
        self.write("stand.csv", stand_csv().replace(",SM,", ",OF,", 60))
        kinds = ([],
                 ["--variance", "power"],
                 ["--random", "a | plot", "--variance", "constant-plus-power"],
                 ["--random", "a + b | plot", "--method", "agq", "--parameter", "b ~ 1 + C"],
                 ["--random", "a | species/plot", "--variance", "stratum(species) * power(dbh)"])
        for kind in kinds:
            with self.subTest(kind=kind):
                fit = self.run_json("fit", "stand.csv", "--formula", FORMULA, *kind)
                check_fit(fit)

    def test_a_failed_fit_obeys_the_schema(self):
        self.write("flat.csv", "dbh,h\n10,5\n10,6\n10,7\n10,8\n")
        fit = self.run_json("fit", "flat.csv", "--formula", FORMULA, status=4)
        self.assertFalse(fit["converged"])
        check_fit(fit)

    def test_a_study_leaves_a_library_that_obeys_the_schema(self):
        inventory = SOURCE / "examples" / "fir-mixed" / "inventory.csv"
        self.run_program("study", str(inventory), "--out", "study", "--species", "SM",
                         "--responses", "h,hcb,cw", "--quiet")
        library = json.loads((self.folder / "study/library.json").read_text(encoding="utf-8"))
        jsonschema.Draft7Validator(schema("library.schema.json")).validate(library)
        self.assertEqual(len(library["models"]), 9)
        # Trees of the species are commonest somewhere within the range that its models saw.
        low, high = library["models"][0]["fit"]["ranges"]["dbh"]
        self.assertLess(low, library["inventory"]["commonest_dbh"]["SM"])
        self.assertGreater(high, library["inventory"]["commonest_dbh"]["SM"])

    def test_a_published_library_obeys_the_schema(self):
        shown = self.run_json("library", "show", "shanxia-2023")
        jsonschema.Draft7Validator(schema("library.schema.json")).validate(shown)


class Libraries(ProgramTest):
    def test_published_libraries_are_listed_and_shown(self):
        self.assertEqual(self.run_json("library", "show"), {"published": ["shanxia-2023"]})
        shown = self.run_json("library", "show", "shanxia-2023")
        self.assertEqual(len(shown["models"]), 27)
        text = self.run_program("library", "show", "shanxia-2023").stdout
        self.assertIn("h ~ 1.3 + a*(1 - exp(-b*dbh))", text)
        self.assertIn("a 36.7543, b 0.0236, b:C 0.0045", text)

    def test_scenes_are_ready_to_be_grown(self):
        scenes = self.run_program("library", "scenes", "shanxia-2023", "--species", "SM",
                                  "--quiet").stdout
        rows = list(csv.DictReader(io.StringIO(scenes)))
        self.assertEqual(len(rows), 25 * 5)
        self.assertEqual({row["dbh"] for row in rows if row["tree"] == "1"}, {"25.9"})
        self.write("scenes.csv", scenes)
        grown = self.run_json("grow", "scenes.csv", "--out", "trees", "--plot", "SM-C0.5-M0.25")
        self.assertEqual(len(grown["trees"]), 5)

    def test_scenes_are_summed_up_as_json(self):
        summary = self.run_json("library", "scenes", "shanxia-2023", "--species", "SM", "--out", "scenes.csv")
        self.assertEqual(summary["schema"], "silvafit-scenes/1")
        self.assertEqual(summary["species"], [
            {"species": "SM", "dbh": 25.9, "indices": ["C", "M"], "scenes": 25}])
        rows = (self.folder / "scenes.csv").read_text(encoding="utf-8").splitlines()
        self.assertEqual(summary["trees"], len(rows) - 1)
        self.run_program("library", "scenes", "shanxia-2023", "--json", status=2)

    def test_scenes_need_all_three_responses(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", FORMULA, "--random", "a | plot")
        self.write("fit.json", json.dumps(fit))
        error = self.run_program("library", "scenes", "fit.json", "--dbh", "=20", status=2).stderr
        self.assertIn("no model for hcb", error)

    def test_a_published_library_predicts_without_a_fit(self):
        self.write("new.csv", "tree,species,dbh,C,M,U\n1,SM,25.9,0.5,0,0.25\n2,XX,10,0,0,0\n")
        rows = list(csv.DictReader(io.StringIO(
            self.run_program("predict", "--library", "shanxia-2023", "new.csv", "--digits", "17").stdout)))
        height = 1.3 + 36.7543 * (1 - math.exp((-0.0236 - 0.0045 * 0.5) * 25.9))
        self.assertAlmostEqual(float(rows[0]["h_pred"]), height, 9)
        self.assertIn("no model of h for species XX", rows[1]["flag"])
        same = self.run_program("predict", "shanxia-2023", "new.csv", "--digits", "17").stdout
        self.assertEqual(list(csv.DictReader(io.StringIO(same))), rows)
        self.run_program("predict", "new.csv", status=2)

    def test_bad_requests_say_what_to_do(self):
        error = self.run_program("library", "scenes", "nowhere.json", status=3).stderr
        self.assertIn("shanxia-2023", error)
        error = self.run_program("library", "scenes", "shanxia-2023", "--dbh", "SM", status=2).stderr
        self.assertIn("SPECIES=CM", error)


if __name__ == "__main__":
    unittest.main()
