# SPDX-License-Identifier: MIT
"""Files are written whole, to nobody else's place, with the permissions that they had, and are on the disk."""

import fcntl
import json
import os
import shutil
import signal
import stat
import subprocess
import time
import unittest
from pathlib import Path

import preloaded
from silvafit_program import PROGRAM, ProgramTest, stand_csv

EXAMPLE = Path(__file__).parents[2] / "examples" / "fir-mixed" / "inventory.csv"
TREES = "plot,tree,species,x,y,dbh,h,hcb,cw\n" + "".join(
    f"1,{tree},SM,{3 * (tree % 5) + 0.1 * tree:.1f},{3 * (tree // 5) + 0.2:.1f},{10 + tree},{8 + 0.5 * tree},3,2.5\n"
    for tree in range(25))
INPUT_OUTPUT = 5


class WrittenFiles(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("trees.csv", TREES)

    def begin(self, *arguments, environment=None):
        return subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, env=environment, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL,
                                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))

    def names(self):
        return sorted(path.name for path in self.folder.iterdir())

    def permissions(self, name):
        return stat.S_IMODE((self.folder / name).stat().st_mode)

    def indices(self, out="o.csv", **more):
        return subprocess.run([PROGRAM, "indices", "trees.csv", "--out", out, "--quiet"], cwd=self.folder,
                              capture_output=True, text=True, timeout=60, check=False, **more)

    def test_two_processes_with_one_number_do_not_share_a_file(self):
        # As in two containers that share a folder.
        environment = preloaded.library(self.folder, "one_number", preloaded.ONE_NUMBER)
        lines = EXAMPLE.read_text(encoding="utf-8").splitlines(keepends=True)
        whole = {}
        for name, rows in (("A", lines[:2500]), ("B", lines[:1] + lines[2500:])):
            self.write(f"{name}.csv", "".join(rows))
            self.run_program("indices", f"{name}.csv", "--out", f"{name}-alone.csv", "--quiet")
            whole[name] = (self.folder / f"{name}-alone.csv").read_bytes()
        for _ in range(6):
            both = [self.begin("indices", f"{name}.csv", "--out", "o.csv", environment=environment) for name in whole]
            self.assertEqual([one.wait(timeout=60) for one in both], [0, 0])
            self.assertIn((self.folder / "o.csv").read_bytes(), whole.values())

    def test_a_link_under_a_name_that_can_be_guessed_is_not_followed(self):
        environment = preloaded.library(self.folder, "one_number", preloaded.ONE_NUMBER)
        self.write("victim", "mine")
        for counter in range(3):
            os.symlink("victim", self.folder / f"o.csv.7.{counter}.part")
        self.assertEqual(self.indices(env=environment).returncode, 0)
        self.assertEqual((self.folder / "victim").read_text(encoding="utf-8"), "mine")

    def test_a_replaced_file_keeps_its_permissions_and_a_new_one_has_the_usual(self):
        self.indices(umask=0o027)
        self.assertEqual(self.permissions("o.csv"), 0o640)
        for mode in (0o600, 0o664, 0o755):
            (self.folder / "o.csv").chmod(mode)
            self.indices(umask=0o027)
            self.assertEqual(self.permissions("o.csv"), mode)

    def test_a_link_stays_one_and_its_target_is_written(self):
        (self.folder / "elsewhere").mkdir()
        self.write("elsewhere/target.csv", "old")
        os.symlink("elsewhere/target.csv", self.folder / "o.csv")
        os.symlink("o.csv", self.folder / "second.csv")
        os.symlink("elsewhere/new.csv", self.folder / "dangling.csv")
        for name, target in (("second.csv", "target.csv"), ("dangling.csv", "new.csv")):
            self.assertEqual(self.indices(name).returncode, 0)
            self.assertTrue((self.folder / name).is_symlink())
            self.assertIn("plot,tree", (self.folder / "elsewhere" / target).read_text(encoding="utf-8"))
        os.symlink("round.csv", self.folder / "round.csv")
        done = self.indices("round.csv")
        self.assertEqual(done.returncode, INPUT_OUTPUT)
        self.assertIn("symbolic links", done.stderr)

    def test_bytes_are_on_the_disk_before_their_name_and_the_name_at_the_end(self):
        environment = preloaded.library(self.folder, "disk", preloaded.FAILING_DISK)
        log = self.folder / "log"
        self.indices(env=environment | {"FAIL_LOG": str(log)})
        calls = [line.split()[:2] for line in log.read_text(encoding="utf-8").splitlines()]
        self.assertEqual([call for call in calls if call[0] != "write"],
                         [["fsync", "file"], ["close", "file"], ["rename", str("o.csv")], ["fsync", "folder"]])
        self.assertEqual(calls[-5][0], "write")

    def test_whichever_call_of_the_disk_fails_the_old_file_or_the_whole_new_one_is_there(self):
        environment = preloaded.library(self.folder, "disk", preloaded.FAILING_DISK)
        self.indices()
        new = (self.folder / "o.csv").read_bytes()
        before = self.names()
        for number in range(1, 20):
            self.write("o.csv", "old")
            done = self.indices(env=environment | {"FAIL_AT": str(number)})
            content = (self.folder / "o.csv").read_bytes()
            self.assertEqual(self.names(), before)
            self.assertIn(content, (b"old", new))
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, INPUT_OUTPUT, done.stderr)
            self.assertIn("o.csv: cannot write (No space left on device)", done.stderr)
        self.assertEqual(done.returncode, 0)
        self.assertGreater(number, 5)  # write, fsync, close, rename, and fsync of the folder were tried

    def test_whichever_call_of_the_disk_fails_a_study_leaves_old_or_new_files(self):
        environment = preloaded.library(self.folder, "disk", preloaded.FAILING_DISK)
        self.write("stand.csv", stand_csv())
        self.write("settings.json", json.dumps({"responses": ["h"], "minimum_trees": 50, "candidates": {"h": ["M4", "M5"]}}))
        study = ("study", "stand.csv", "--config", "settings.json", "--quiet", "--out", "out", "--threads", "1")
        out = self.folder / "out"

        def contents():
            return {path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()}

        log = self.folder / "log"
        self.assertEqual(self.begin(*study, environment=environment | {"FAIL_LOG": str(log)}).wait(timeout=60), 0)
        new = contents()
        calls = [line.split()[0] for line in log.read_text(encoding="utf-8").splitlines()]
        for call in ("write", "fsync", "close", "rename"):
            self.assertGreaterEqual(calls.count(call), len(new))
        old = {name: b"old" for name in new}
        # Every seventh call, which is each kind of call for some of the fifty files.
        for number, call in list(enumerate(calls, 1))[::7]:
            for name in new:
                (out / name).write_bytes(old[name])
            done = subprocess.run([PROGRAM, *study], cwd=self.folder, env=environment | {"FAIL_AT": str(number)},
                                  capture_output=True, text=True, timeout=60, check=False)
            found = contents()
            self.assertEqual(found.keys(), new.keys())
            if done.returncode == 0:  # of a temporary file that holds no result
                self.assertEqual(call, "close")
                self.assertNotIn(b"old", found.values())
            else:
                self.assertEqual(done.returncode, INPUT_OUTPUT, f"call {number}: {done.stderr}")
                self.assertIn("cannot write (No space left on device)", done.stderr)
            for name, content in found.items():
                # Times of a run are its own.
                is_new = json.loads(content) if name.name == "run.json" and content != b"old" else content == new[name]
                self.assertTrue(content == b"old" or is_new, f"call {number}: {name}")

    def test_two_studies_do_not_write_into_one_folder(self):
        study = ("study", str(EXAMPLE), "--out", "out", "--quiet")
        first = self.begin(*study)
        while not (self.folder / "out").exists() and first.poll() is None:
            time.sleep(0.001)
        time.sleep(0.1)
        second = subprocess.run([PROGRAM, *study], cwd=self.folder, capture_output=True, text=True, timeout=120, check=False)
        self.assertIsNone(first.poll(), "the first study was too quick")
        self.assertEqual(second.returncode, INPUT_OUTPUT)
        self.assertIn("out: another silvafit is writing into this folder", second.stderr)
        self.assertEqual(first.wait(timeout=120), 0)
        self.assertTrue((self.folder / "out" / "run.json").is_file())

    def test_a_folder_of_results_has_one_writer(self):
        out = self.folder / "out"
        out.mkdir()
        held = os.open(out, os.O_RDONLY)
        self.addCleanup(os.close, held)
        fcntl.flock(held, fcntl.LOCK_EX)
        for command in ("study", "stand", "grow"):
            done = subprocess.run([PROGRAM, command, str(EXAMPLE), "--out", "out", "--quiet"], cwd=self.folder,
                                  capture_output=True, text=True, timeout=120, check=False)
            self.assertEqual(done.returncode, INPUT_OUTPUT, command)
            self.assertIn("out: another silvafit is writing into this folder", done.stderr)
            self.assertEqual(list(out.iterdir()), [])

    def test_a_full_disk_is_an_error_of_input_and_output(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([PROGRAM, "models"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(done.returncode, INPUT_OUTPUT)
        done = self.indices("/dev/full")
        self.assertEqual(done.returncode, INPUT_OUTPUT)
        self.assertIn("/dev/full: cannot write (No space left on device)", done.stderr)

    def test_long_names_have_room_for_a_temporary_one(self):
        name = "o" * 251 + ".csv"
        self.assertEqual(self.indices(name).returncode, 0)
        self.assertIn(name, self.names())

    def interrupted(self, delay, number, *arguments):
        process = self.begin(*arguments)
        time.sleep(delay)
        process.send_signal(number)
        self.assertIn(process.wait(timeout=60), (0, -number))

    def test_an_interrupt_leaves_no_unfinished_file(self):
        begin = time.monotonic()
        grow = ("grow", str(EXAMPLE), "--plot", "1", "--lod", "2", "--format", "obj", "--out")
        self.run_program(*grow, "whole", "--quiet")
        seconds = time.monotonic() - begin
        trials = 24
        for i in range(trials):
            self.interrupted(seconds * i / trials, signal.SIGTERM if i % 2 else signal.SIGINT, *grow, "out")
            if not (self.folder / "out").exists():
                continue
            self.assertEqual([path.name for path in (self.folder / "out").iterdir() if path.suffix == ".part"], [])
            self.assertNotEqual(list((self.folder / "out").iterdir()), [], "an empty folder")
            shutil.rmtree(self.folder / "out")

    def test_an_interrupt_leaves_no_empty_folder(self):
        for i in range(12):
            process = self.begin("study", str(EXAMPLE), "--out", "new/deep/out")
            while not (self.folder / "new").exists() and process.poll() is None:
                time.sleep(0.001)
            time.sleep(0.005 * i)
            number = signal.SIGTERM if i % 2 else signal.SIGINT
            process.send_signal(number)
            self.assertEqual(process.wait(timeout=60), -number, "it ended before it was interrupted")
            self.assertFalse((self.folder / "new").exists())
        # What was there before stays.
        (self.folder / "mine").mkdir()
        process = self.begin("study", str(EXAMPLE), "--out", "mine/out")
        while not (self.folder / "mine" / "out").exists() and process.poll() is None:
            time.sleep(0.001)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60)
        self.assertEqual(list((self.folder / "mine").iterdir()), [])

    def test_an_error_leaves_no_empty_folder(self):
        environment = preloaded.library(self.folder, "disk", preloaded.FAILING_DISK)
        done = self.indices("new/deep/o.csv", env=environment | {"FAIL_AT": "1"})
        self.assertEqual(done.returncode, INPUT_OUTPUT)
        self.assertFalse((self.folder / "new").exists())


if __name__ == "__main__":
    unittest.main()
