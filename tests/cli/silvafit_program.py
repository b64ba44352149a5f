# SPDX-License-Identifier: MIT
"""Runs the program in an empty folder, and writes the small files that it is given."""

import json
import math
import os
import random
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["SILVAFIT_PROGRAM"]


class ProgramTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="silvafit-cli-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return name

    def run_program(self, *arguments, status=0):
        """Both outputs as text; fails unless the exit status is the wanted one."""
        done = subprocess.run(
            [PROGRAM, *arguments],
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        self.assertEqual(done.returncode, status, f"{arguments}\n{done.stderr}")
        return done

    def run_json(self, *arguments, status=0):
        return json.loads(self.run_program(*arguments, "--json", status=status).stdout)


def stand_csv(plots=6, trees=20, seed=3):
    """Heights of a Meyer curve whose limit differs between plots."""
    draw = random.Random(seed)
    lines = ["plot,tree,species,dbh,h,C"]
    tree = 0
    for plot in range(1, plots + 1):
        limit = 25 + draw.gauss(0, 2)
        for _ in range(trees):
            tree += 1
            dbh = round(draw.uniform(6, 50), 1)
            crowding = draw.choice([0, 0.25, 0.5, 0.75, 1])
            rate = 0.05 - 0.01 * crowding
            h = 1.3 + limit * (1 - math.exp(-rate * dbh)) + draw.gauss(0, 0.5)
            lines.append(f"{plot:02d},{tree},SM,{dbh},{h:.2f},{crowding}")
    return "\n".join(lines) + "\n"
