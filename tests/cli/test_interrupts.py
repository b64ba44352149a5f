# SPDX-License-Identifier: MIT
"""A program that is interrupted leaves whole files only."""

import csv
import json
import os
import signal
import subprocess
import time
import unittest
from pathlib import Path

from silvafit_program import PROGRAM, ProgramTest

INVENTORY = Path(__file__).parents[2] / "examples" / "fir-mixed" / "inventory.csv"


class Interrupts(ProgramTest):
    def interrupted_study(self, out, delay, number):
        process = subprocess.Popen(
            [PROGRAM, "study", str(INVENTORY), "--out", out, "--species", "SM"],
            cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            preexec_fn=lambda: signal.signal(number, signal.SIG_DFL))
        time.sleep(delay)
        process.send_signal(number)
        return process.wait(timeout=60)

    def assert_whole(self, folder):
        for path in folder.rglob("*"):
            if path.is_dir():
                continue
            self.assertNotEqual(path.suffix, ".part", path)
            text = path.read_text(encoding="utf-8")
            if path.suffix == ".json":
                json.loads(text)
            elif path.suffix == ".html":
                self.assertTrue(text.rstrip().endswith("</html>"))
            elif path.suffix == ".csv":
                rows = list(csv.reader(text.splitlines()))
                self.assertTrue(text.endswith("\n"))
                self.assertEqual({len(row) for row in rows}, {len(rows[0])}, path)

    def test_a_study_leaves_whole_files_whenever_it_is_interrupted(self):
        ended = set()
        for i in range(16):
            out = f"study{i}"
            number = signal.SIGTERM if i % 2 else signal.SIGINT
            status = self.interrupted_study(out, 0.04 * i, number)
            self.assertIn(status, (0, -number))
            ended.add(status)
            self.assert_whole(self.folder / out)
        self.assertIn(-signal.SIGINT, ended)

    def test_a_page_in_3d_leaves_no_folder_among_the_temporary_files(self):
        # The models of the page pass through a folder of their own.
        temporary = self.folder / "temporary"
        temporary.mkdir()

        def start():
            return subprocess.Popen(
                [PROGRAM, "view", str(INVENTORY), "--plot", "1,2,3", "--models", "40", "--out", "page.html", "--no-open"],
                cwd=self.folder, env=os.environ | {"TMPDIR": str(temporary)}, stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))

        for i in range(12):
            process = start()
            while not list(temporary.iterdir()) and process.poll() is None:
                time.sleep(0.002)
            self.assertIsNone(process.poll(), "it ended before it had a temporary folder")
            time.sleep(0.01 * i)
            number = signal.SIGTERM if i % 2 else signal.SIGINT
            process.send_signal(number)
            self.assertIn(process.wait(timeout=60), (0, -number))
            self.assertEqual(list(temporary.iterdir()), [])
            self.assertEqual([path.name for path in self.folder.iterdir() if path.suffix == ".part"], [])

    def test_a_folder_that_cannot_be_written_is_refused_before_the_fits(self):
        self.write("file", "")
        error = self.run_program("study", str(INVENTORY), "--out", "file", status=5).stderr
        self.assertIn("file: cannot make the folder", error)
        self.assertEqual(os.listdir(self.folder), ["file"])


if __name__ == "__main__":
    unittest.main()
