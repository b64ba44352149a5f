# SPDX-License-Identifier: MIT
"""What goes wrong around the program ends with a message, and leaves nothing half-written."""

import csv
import itertools
import json
import os
import random
import resource
import signal
import subprocess
import time
import unittest
from pathlib import Path

from silvafit_program import PROGRAM, ProgramTest, stand_csv

EXAMPLE = Path(__file__).parents[2] / "examples" / "fir-mixed" / "inventory.csv"
NOBODY = 65534


def limited(limit, value):
    """For a child: a limit of resources; a file that grows too large is an error of the write, as on a full disk."""

    def apply():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(limit, (value, value))

    return apply


def whole(path):
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".json":
        json.loads(text)
    elif path.suffix == ".html":
        assert text.rstrip().endswith("</html>"), path
    elif path.suffix == ".csv":
        rows = list(csv.reader(text.splitlines()))
        assert text.endswith("\n") and {len(row) for row in rows} == {len(rows[0])}, path
    return True


class Faults(ProgramTest):
    def run_in(self, prepare, *arguments, **more):
        return subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=120, check=False, preexec_fn=prepare, **more)

    def files(self):
        return sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*") if path.is_file())

    def test_a_full_disk_ends_the_study_with_whole_files_only(self):
        # The report needs more than 200 kB.
        done = self.run_in(limited(resource.RLIMIT_FSIZE, 200_000), "study", str(EXAMPLE), "--species", "SM",
                           "--responses", "h", "--out", "out")
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertIn("cannot write", done.stderr)
        for path in (self.folder / "out").rglob("*"):
            self.assertNotEqual(path.suffix, ".part")
            if path.is_file():
                self.assertTrue(whole(path))

    def test_a_full_disk_leaves_no_scene(self):
        done = self.run_in(limited(resource.RLIMIT_FSIZE, 200_000), "grow", str(EXAMPLE), "--plot", "1",
                           "--scene", "stand.glb")
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertIn("stand.glb", done.stderr)
        self.assertEqual(self.files(), [])

    def test_results_that_nobody_can_read_are_an_error(self):
        self.write("stand.csv", stand_csv())
        for arguments in (["models"], ["fit", "stand.csv", "--model", "M4", "--json"], ["library", "show", "shanxia-2023"]):
            with open("/dev/full", "w", encoding="utf-8") as full:
                done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, stdout=full, stderr=subprocess.PIPE,
                                      text=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 5, arguments)
            self.assertIn("standard output", done.stderr)

    def test_a_folder_without_permission_is_refused_before_the_work(self):
        locked = self.folder / "locked"
        locked.mkdir()
        locked.chmod(0o555)
        self.folder.chmod(0o755)

        def without_rights():
            if os.getuid() == 0:
                os.setuid(NOBODY)

        for arguments in (["study", str(EXAMPLE), "--out", "locked/out"], ["grow", str(EXAMPLE), "--scene", "locked/s.glb"]):
            done = self.run_in(without_rights, *arguments)
            self.assertEqual(done.returncode, 5, done.stderr)
            self.assertIn("Permission denied", done.stderr)
        self.assertEqual(self.files(), [])

    def test_a_killed_study_leaves_whole_files_and_can_be_repeated(self):
        # SIGKILL gives no time to tidy up: a file under construction may stay, under its own name.
        draw = random.Random(4)
        self.write("stand.csv", stand_csv())
        begin = time.monotonic()
        self.run_program("study", "stand.csv", "--out", "whole", "--minimum-trees", "50")
        seconds = time.monotonic() - begin
        written = {str(path.relative_to(self.folder / "whole")) for path in (self.folder / "whole").rglob("*")}
        killed = 0
        for _ in range(40):
            process = subprocess.Popen([PROGRAM, "study", "stand.csv", "--out", "out", "--minimum-trees", "50"],
                                       cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(draw.uniform(0, seconds))
            process.kill()
            killed += process.wait(timeout=60) == -signal.SIGKILL
            for path in (self.folder / "out").rglob("*"):
                if path.is_file() and path.suffix != ".part":
                    self.assertTrue(whole(path), path)
        self.assertGreater(killed, 12)
        self.run_program("study", "stand.csv", "--out", "out", "--minimum-trees", "50")
        here = {str(path.relative_to(self.folder / "out")) for path in (self.folder / "out").rglob("*")
                if path.suffix != ".part"}
        self.assertEqual(here, written)

    def test_too_little_memory_is_said(self):
        rows = "".join(f"{i},1,SM,{20 * (i % 600)},{20 * (i // 600)},{10 + i % 30},12,5,3\n" for i in range(240000))
        self.write("plots.csv", "plot,tree,species,x,y,dbh,h,hcb,cw\n" + rows)
        done = self.run_in(limited(resource.RLIMIT_AS, 100 << 20), "indices", "plots.csv", "--out", "indices.csv")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("out of memory", done.stderr)
        self.assertEqual(self.files(), ["plots.csv"])


class LargeAndOdd(ProgramTest):
    """Sizes for every day; SILVAFIT_LARGE=1 multiplies them by ten, up to a million."""

    times = 10 if os.environ.get("SILVAFIT_LARGE") else 1

    def test_many_columns(self):
        count = 100_000 * self.times
        header = "plot,tree,species,x,y,dbh,h,hcb,cw," + ",".join(f"c{i}" for i in range(count))
        rows = "".join(f"1,{t},SM,{t},{t},{10 + 2 * t},{9 + t},3,2{',1' * count}\n" for t in range(4))
        self.write("wide.csv", header + "\n" + rows)
        fit = self.run_json("fit", "wide.csv", "--formula", "h ~ a + b*dbh")
        self.assertAlmostEqual(fit["fixed"]["b"]["estimate"], 0.5, places=12)
        error = self.run_program("fit", "wide.csv", "--formula", "h ~ a + b*dbh", "--where", "nothing > 1", status=3).stderr
        self.assertLess(len(error), 2000)
        self.run_program("grow", "wide.csv", "--scene", "s.glb", "--quiet")

    def test_many_plots_and_a_large_one(self):
        draw = random.Random(5)
        count = 100_000 * self.times

        def tree(plot, number):
            dbh = draw.uniform(8, 40)
            h = 1.3 + 25 * (1 - 2.718281828 ** (-0.05 * dbh)) + draw.gauss(0, 0.5)
            return f"{plot},{number},SM,{dbh:.3f},{h:.3f}\n"

        header = "plot,tree,species,dbh,h\n"
        self.write("many.csv", header + "".join(tree(i // 2, i) for i in range(count)))
        self.write("one.csv", header + "".join(tree(1, i) for i in range(count)))
        formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))"
        # The standard errors are below 0.05 and 0.0003 at this size.
        for arguments in (["many.csv"], ["one.csv"], ["many.csv", "--random", "a | plot"]):
            fixed = self.run_json("fit", *arguments, "--formula", formula)["fixed"]
            self.assertAlmostEqual(fixed["a"]["estimate"], 25, delta=0.25)
            self.assertAlmostEqual(fixed["b"]["estimate"], 0.05, delta=0.0015)

    def cost(self, *arguments):
        """Processor time [s] and peak of memory [MB] of a run: they mind other work on the machine less than a clock."""
        with open(self.folder / "messages", "w", encoding="utf-8") as messages:
            process = subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, stdout=messages, stderr=messages)
            _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        said = (self.folder / "messages").read_text(encoding="utf-8")
        self.assertEqual(process.returncode, 0, said[-2000:])
        return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, said

    def test_units_of_many_small_plots(self):
        draw = random.Random(8)
        count = 100_000 * self.times
        header = "plot,tree,species,x,y,dbh\n"
        self.write("alone.csv", header + "".join(f"{i},{i},SM,5,5,20\n" for i in range(count)))
        seconds, megabytes, said = self.cost("indices", "alone.csv", "--out", "alone-units.csv")
        # Taken: 0.3 s and 45 MB; with a search tree of each plot kept, 480 MB.
        self.assertLess(megabytes, 250 * self.times)
        self.assertLess(seconds, 10 * self.times)
        self.assertIn(f"{count - 40} more", said)  # not a hundred thousand names
        self.assertLess(len(said), 5000)

        self.write("five.csv", header + "".join(
            f"{i // 5},{i},SM,{draw.uniform(-5, 5):.2f},{draw.uniform(-5, 5):.2f},20\n" for i in range(5 * count)))
        seconds, _, _ = self.cost("indices", "five.csv", "--circle", "0,0,10", "--edge", "hanisch", "--out", "units.csv")
        # Taken: 1 s; where the weights of each window look at all trees, more than 100 s.
        self.assertLess(seconds, 20 * self.times)

        def head(name, lines):
            with open(self.folder / name, encoding="utf-8") as file:
                return "".join(itertools.islice(file, lines))

        # Those of the first plots are as if there were no others.
        self.write("few.csv", head("five.csv", 51))
        self.run_program("indices", "few.csv", "--circle", "0,0,10", "--edge", "hanisch", "--out", "few-units.csv")
        self.assertEqual(head("units.csv", 51), head("few-units.csv", 100))

    def test_odd_numbers_everywhere_end_with_a_message(self):
        draw = random.Random(6)
        values = ["nan", "NaN", "1e308", "-1e308", "inf", "-inf", "1e-308", "0", "", "NA", "12.5"]
        header = "plot,tree,species,x,y,dbh,h,hcb,cw,cr_e,cr_w,cr_s,cr_n,hc,age\n"
        for share in (0.02, 0.5, 1.0):
            rows = ""
            for t in range(300):
                dbh = draw.uniform(8, 40)
                good = [3 * (t % 17), 3 * (t // 17), dbh, 5 + dbh / 3, 2 + dbh / 10, 2, 1, 1.2, 0.9, 1.1, 4 + dbh / 9, 30]
                cells = [draw.choice(values) if draw.random() < share else f"{value:.2f}" for value in good]
                rows += f"{draw.choice('12')},{t},SM," + ",".join(cells) + "\n"
            self.write("odd.csv", header + rows)
            for command in ("indices odd.csv --out o.csv", "fit odd.csv --model all:h", "study odd.csv --out out --minimum-trees 20",
                            "grow odd.csv --scene s.glb", "grow odd.csv --scene s.glb --resolve-overlaps",
                            "impute odd.csv --response h --out i.csv", "stand odd.csv"):
                done = subprocess.run([PROGRAM, *command.split()], cwd=self.folder, capture_output=True, text=True,
                                      timeout=120, check=False)
                self.assertIn(done.returncode, (0, 2, 3, 4), f"{command}\n{done.stderr[-2000:]}")
                self.assertNotIn("internal error", done.stderr)


if __name__ == "__main__":
    unittest.main()
