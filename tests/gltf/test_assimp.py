# SPDX-License-Identifier: MIT
"""Scenes as assimp reads them: test_assimp.py FOLDER, with the files that grow_samples has written."""

import json
import pathlib
import re
import subprocess
import sys
import unittest

FOLDER = pathlib.Path(sys.argv.pop())


def info(name):
    done = subprocess.run(["assimp", "info", str(FOLDER / name)], capture_output=True, text=True,
                          timeout=120, check=False)
    return done.returncode, done.stdout + done.stderr


def point(text, which):
    numbers = re.search(which + r"\s+point\s+\(([^)]*)\)", text)[1]
    return [float(number) for number in numbers.split()]


class Assimp(unittest.TestCase):
    def setUp(self):
        self.expected = json.loads((FOLDER / "expected.json").read_text())

    def check_extent(self, text):
        # assimp prints six digits; radii are right to 1 cm.
        self.assertAlmostEqual(point(text, "Maximum")[1], self.expected["top"], delta=0.002)
        self.assertAlmostEqual(point(text, "Maximum")[0], self.expected["east"], delta=0.011)
        self.assertAlmostEqual(point(text, "Minimum")[0], self.expected["west"], delta=0.011)

    def test_scenes_with_shared_meshes_have_every_tree_at_its_place(self):
        for name in ("plain.glb", "plain.gltf"):
            with self.subTest(name=name):
                status, text = info(name)
                self.assertEqual(status, 0, text)
                self.check_extent(text)

    def test_obj_and_ply_have_all_triangles(self):
        for name in ("scene.obj", "scene.ply", "text.ply"):
            with self.subTest(name=name):
                status, text = info(name)
                self.assertEqual(status, 0, text)
                self.check_extent(text)
                self.assertEqual(int(re.search(r"Faces:\s+(\d+)", text)[1]), self.expected["triangles"])


if __name__ == "__main__":
    unittest.main()
