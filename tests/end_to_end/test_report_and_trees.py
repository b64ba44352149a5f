# SPDX-License-Identifier: MIT
"""What a study of every species leaves can be looked at and grown: report in a browser, plot as GLB."""

import json
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

from silvafit_program import PROGRAM
from study_folder import EXAMPLE, StudyFolder, run_node

PLOT = "3"
MAIN_SPECIES = ("SM", "BHN", "MH")


def glb_json(path):
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length])


class ReportAndTrees(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="silvafit-study-")
        cls.addClassCleanup(temporary.cleanup)
        cls.place = Path(temporary.name)
        cls.run_program("study", EXAMPLE / "inventory.csv", "--out", "study", "--window",
                        EXAMPLE / "window.geojson", "--per", "stand", "--quiet")
        cls.folder = StudyFolder(cls.place / "study")

    @classmethod
    def run_program(cls, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=cls.place, capture_output=True,
                              text=True, timeout=240, check=True)

    def test_every_species_and_response_has_a_model_to_rely_on(self):
        results = {(result["species"], result["response"]): result
                   for result in self.folder.report["results"]}
        # SD has 109 trees, 96 of them inside the buffer: too few.
        self.assertEqual(len(results), 7 * 3)
        self.assertNotIn("SD", {species for species, _ in results})
        self.assertTrue(any("SD h, hcb, cw (96 core trees of 109 measured)" in note for note in self.folder.report["notes"]))
        for species in MAIN_SPECIES:
            for response in ("h", "hcb", "cw"):
                self.assertTrue(results[(species, response)]["converged"], (species, response))

    def test_mixed_models_are_no_less_likely_than_least_squares(self):
        fits = self.folder.fits()
        for (species, response, role), fit in fits.items():
            if role == "nlme":
                below = fits[(species, response, "covariates")]["log_likelihood"]
                self.assertGreaterEqual(fit["log_likelihood"], below - 1e-6, (species, response))

    def test_the_report_opens_in_a_browser(self):
        opened = run_node("SILVAFIT_CHECK_REPORT", self.place / "study" / "report.html")
        self.assertEqual(opened.returncode, 0, opened.stderr)
        self.assertIn("21 results", opened.stdout)

    def grow(self, use):
        scene = f"{use}.glb"
        grown = json.loads(self.run_program("grow", "study/predictions.csv", "--use", use,
                                            "--plot", PLOT, "--scene", scene, "--json",
                                            "--quiet").stdout)
        valid = run_node("SILVAFIT_GLTF_VALIDATOR", self.place / scene)
        self.assertEqual(valid.returncode, 0, valid.stdout + valid.stderr)
        return grown["trees"], glb_json(self.place / scene)

    def test_a_plot_of_measured_trees_grows(self):
        trees, scene = self.grow("observed")
        rows = {row["tree"]: row for row in self.folder.predictions if row["plot"] == PLOT}
        self.assertEqual({str(tree["tree"]) for tree in trees}, set(rows))
        self.assertGreaterEqual(len(scene["nodes"]), len(rows))
        for tree in trees:
            self.assertAlmostEqual(tree["h"], float(rows[str(tree["tree"])]["h"]), delta=0.01)

    def test_a_plot_of_predicted_trees_grows(self):
        trees, _ = self.grow("conditional")
        rows = {row["tree"]: row for row in self.folder.predictions if row["plot"] == PLOT}
        for tree in trees:
            row = rows[str(tree["tree"])]
            self.assertAlmostEqual(tree["h"], float(row["h_conditional"]), delta=0.01)


if __name__ == "__main__":
    unittest.main()
