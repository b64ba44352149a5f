# SPDX-License-Identifier: MIT
"""Studies: what is checked before the fits, what is left behind, and settings that come back as they were given."""

import os
import subprocess
import unittest
from pathlib import Path

from silvafit_program import PROGRAM, ProgramTest, stand_csv


class ProgramWithoutPages(ProgramTest):
    """A data folder such as SILVAFIT_BUILD_VIEWER=OFF leaves it."""

    def setUp(self):
        super().setUp()
        self.write("trees.csv", stand_csv())
        models = Path(__file__).parents[2] / "models"
        (self.folder / "share").mkdir()
        os.symlink(models, self.folder / "share" / "models")

    def run_without_pages(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=120,
                              check=False, env={**os.environ, "SILVAFIT_DATA_DIR": str(self.folder / "share")})
        return done.returncode, done.stderr

    def test_is_refused_before_anything_is_read_or_made(self):
        # The inventory is not there, which would be said first if it were read.
        status, error = self.run_without_pages("study", "none.csv", "--out", "out")
        self.assertEqual(status, 3)
        self.assertIn("viewer/report.html: the page to fill is not here", error)
        self.assertIn("-DSILVAFIT_BUILD_VIEWER=ON", error)
        self.assertFalse((self.folder / "out").exists())
        status, error = self.run_without_pages("view", "none.csv", "--no-open")
        self.assertEqual(status, 3)
        self.assertIn("viewer/scene.html: the page to fill is not here", error)

    def test_settings_to_start_from_need_no_page(self):
        self.assertEqual(self.run_without_pages("study", "trees.csv", "--init", "study.json")[0], 0)


class FolderOfResults(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("bare.csv", "g,x,y\n1,1,2\n1,2,2.5\n")

    def test_goes_with_the_study_that_failed(self):
        self.run_program("study", "bare.csv", "--out", "new/deep/", status=3)
        self.assertFalse((self.folder / "new").exists())
        self.run_program("study", "bare.csv", "--out", "new", status=3)
        self.assertFalse((self.folder / "new").exists())

    def test_stays_where_it_was_there_before(self):
        (self.folder / "old").mkdir()
        self.run_program("study", "bare.csv", "--out", "old/new", status=3)
        self.assertEqual(list((self.folder / "old").iterdir()), [])
        self.run_program("study", "bare.csv", "--out", "old", status=3)
        self.assertTrue((self.folder / "old").is_dir())


if __name__ == "__main__":
    unittest.main()
