# SPDX-License-Identifier: MIT
"""What `silvafit view` makes of studies and scenes opens in a browser with WebGL, draws, and chooses trees."""

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

from silvafit_program import PROGRAM
from study_folder import EXAMPLE, read_csv, run_node

PLOT = "2"


class View(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="silvafit-view-")
        cls.addClassCleanup(temporary.cleanup)
        cls.place = Path(temporary.name)
        cls.run_program("study", EXAMPLE / "inventory.csv", "--out", "study", "--window",
                        EXAMPLE / "window.geojson", "--per", "stand", "--quiet")
        cls.rows = [row for row in read_csv(cls.place / "study/predictions.csv")
                    if row["plot"] == PLOT]

    @classmethod
    def run_program(cls, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=cls.place, capture_output=True,
                              text=True, timeout=240, check=True)

    def drawn(self, *arguments):
        """Statistics of the first picture, and the data, of a page without problems."""
        self.run_program("view", *arguments, "--out", "page.html", "--no-open", "--quiet")
        page = self.place / "page.html"
        # WebGL in software takes its time where several tests run at once.
        checked = run_node("SILVAFIT_CHECK_SCENE", page, timeout=280)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        text = page.read_text(encoding="utf-8")
        data = json.loads(text.split('id="view-data">', 1)[1].split("</script>", 1)[0])
        return json.loads(checked.stdout), data

    def test_a_study_with_observed_and_predicted_trees(self):
        stats, data = self.drawn("study", "--plot", PLOT, "--models", "2", "--lod", "2,3")
        self.assertEqual(stats["listed"], len(self.rows))
        self.assertEqual(stats["trees"], len(self.rows))
        self.assertEqual([variant["name"] for variant in data["variants"]],
                         ["observed", "ols", "population", "conditional"])
        for tree, row in enumerate(self.rows):
            self.assertEqual(data["trees"]["tree"][tree], row["tree"])
            for name in ("h", "hcb", "cw"):
                self.assertAlmostEqual(data["trees"][name][tree], float(row[name]), delta=5e-4)
            for variant in data["variants"][1:]:
                for name in ("h", "hcb", "cw"):
                    predicted = row[f"{name}_{variant['name']}"]
                    if predicted:
                        self.assertAlmostEqual(variant[name][tree], float(predicted), delta=5e-4)
            for index in "WMUC":
                if row[index]:
                    self.assertAlmostEqual(data["trees"][index][tree], float(row[index]), delta=1e-6)

    def test_a_scene_of_trees_with_models_of_their_own(self):
        self.run_program("grow", "study/predictions.csv", "--plot", PLOT, "--scene", "own.glb",
                         "--lod", "3", "--compress", "--quiet")
        stats, _ = self.drawn("own.glb")
        self.assertEqual(stats["trees"], len(self.rows))

    def test_a_scene_of_instances_with_the_table_of_its_trees(self):
        self.run_program("grow", "study/predictions.csv", "--plot", PLOT, "--scene", "many.glb",
                         "--lod", "3", "--share", "--models", "4", "--instancing", "--compress",
                         "--quiet")
        stats, _ = self.drawn("many.glb", "--trees", "study/predictions.csv", "--plot", PLOT)
        self.assertEqual(stats["trees"], len(self.rows))
        bare, _ = self.drawn("many.glb")
        self.assertEqual(bare["listed"], 0)


if __name__ == "__main__":
    unittest.main()
