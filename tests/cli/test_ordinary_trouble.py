# SPDX-License-Identifier: MIT
"""Trouble that a user or a machine may have is said in plain words, never as an internal error."""

import json
import os
import random
import resource
import shutil
import struct
import subprocess
import unittest
from pathlib import Path

import preloaded
from silvafit_program import PROGRAM, ProgramTest, stand_csv

EXAMPLE = Path(__file__).parents[2] / "examples" / "fir-mixed" / "inventory.csv"
NOBODY = 65534

# Each command with the name of a file or folder that it reads, {}.
READING = ("compare {} fit.json", "compare fit.json {}", "predict {} stand.csv", "predict fit.json {}", "library show {}",
           "library scenes {} --out s.csv", "view {} --no-open", "view s.glb --trees {} --no-open", "study {} --out out",
           "study {} --init s.json", "study stand.csv --out out --config {}", "indices {} --out i.csv",
           "indices stand.csv --window {} --out i.csv", "stand {}", "fit {} --model M4", "impute {} --out i.csv",
           "grow {} --scene s.glb", "simulate {} --out s.csv", "render {} --out p.png")
# Each with a name that it writes.
WRITING = ("study stand.csv --init {}", "study stand.csv --out {}", "indices trees.csv --out {}", "stand trees.csv --out {}",
           "predict fit.json stand.csv --out {}", "impute gaps.csv --out {}", "grow trees.csv --scene {}",
           "grow trees.csv --out {}", "fit stand.csv --model M4 --residuals {}")


class OrdinaryTrouble(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("stand.csv", stand_csv())
        rows = stand_csv().splitlines()
        self.write("gaps.csv", "\n".join(row if i % 3 else ",".join(row.split(",")[:4]) + ",,0"
                                         for i, row in enumerate(rows, 1)) + "\n")
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h,hcb,cw\n1,1,SM,1,1,20,15,7,3\n1,2,SM,4,4,22,16,7,3\n1,3,SM,4,1,18,14,7,3\n")
        self.write("fit.json", self.run_program("fit", "stand.csv", "--model", "M4", "--json").stdout)

    def end_of(self, *arguments, **more):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=120,
                              check=False, **more)
        said = f"{arguments}: status {done.returncode}\n{done.stderr[-2000:]}"
        for foreign in ("internal error", "filesystem error", "json.exception", "terminate called", "basic_", "std::"):
            self.assertNotIn(foreign, done.stderr, said)
        return done

    def test_names_that_no_file_can_have(self):
        os.symlink("loop", self.folder / "loop")
        self.write("file", "")
        for name in ("n" * 300, "loop", "loop/file", "file/inside"):
            for command in READING:
                done = self.end_of(*[name if word == "{}" else word for word in command.split()])
                self.assertIn(done.returncode, (2, 3), f"{command} {name[:20]}: {done.stderr}")
            for command in WRITING:
                done = self.end_of(*[name if word == "{}" else word for word in command.split()])
                self.assertIn(done.returncode, (3, 5), f"{command} {name[:20]}: {done.stderr}")

    def test_folders_that_may_not_be_searched(self):
        locked = self.folder / "locked"
        locked.mkdir()
        shutil.copy(self.folder / "stand.csv", locked / "file")
        locked.chmod(0)
        self.folder.chmod(0o777)
        self.addCleanup(lambda: locked.chmod(0o755))

        def without_rights():
            if os.getuid() == 0:
                os.setuid(NOBODY)

        for commands, statuses in ((READING, (2, 3)), (WRITING, (3, 5))):
            for command in commands:
                done = self.end_of(*command.replace("{}", "locked/file").split(), preexec_fn=without_rights)
                self.assertIn(done.returncode, statuses, f"{command}: {done.stderr}")
                if done.returncode != 2:
                    self.assertIn("Permission denied", done.stderr, command)

    def test_a_file_that_cannot_be_read_to_its_end(self):
        # The memory of the process itself: it opens as a file, and reading from its beginning fails.
        for command in ("compare {} fit.json", "predict {} stand.csv", "library show {}", "grow trees.csv --scene s.glb --preset {}"):
            done = self.end_of(*command.replace("{}", "/proc/self/mem").split())
            self.assertIn(done.returncode, (2, 5), done.stderr)
        done = self.end_of("predict", "/proc/self/mem", "stand.csv")
        self.assertEqual(done.returncode, 5)
        self.assertIn("/proc/self/mem: cannot read (Input/output error)", done.stderr)
        self.assertIn(self.end_of("indices", "/proc/self/mem").returncode, (3, 5))

    def test_a_machine_without_proc(self):
        environment = preloaded.library(self.folder, "no_proc", preloaded.NO_PROC)
        done = self.end_of("fit", "stand.csv", "--model", "M4", env=environment)  # finds the catalogue
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.end_of("study", "stand.csv", "--minimum-trees", "50", "--out", "out", env=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        run = json.loads((self.folder / "out" / "run.json").read_text(encoding="utf-8"))
        self.assertEqual(run["command"], "silvafit study stand.csv --minimum-trees 50 --out out")

    def test_a_machine_without_threads(self):
        environment = preloaded.library(self.folder, "no_threads", preloaded.NO_THREADS)
        done = self.end_of("fit", "stand.csv", "--model", "M4", "--threads", "1", env=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.end_of("fit", "stand.csv", "--model", "all:h", "--threads", "4", env=environment)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        if done.returncode == 1:
            self.assertIn("no more threads", done.stderr)

    def test_too_little_memory_for_a_picture_is_not_a_fit_that_did_not_converge(self):
        if json.loads(self.run_program("--version", "--json").stdout)["render"] is None:
            self.skipTest("this silvafit draws no pictures")
        self.run_program("grow", str(EXAMPLE), "--plot", "1", "--lod", "1", "--scene", "stand.glb", "--quiet")
        ended = []
        for megabytes in range(60, 700, 40):
            limit = megabytes << 20
            done = self.end_of("render", "stand.glb", "--out", "p.png", "--size", "64x64", "--samples", "1",
                               preexec_fn=lambda limit=limit: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
            ended.append(done.returncode)
            if done.returncode == 1:
                # The stacks of threads need memory, too.
                self.assertRegex(done.stderr, "out of memory|no more threads")
        self.assertLessEqual(set(ended), {0, 1, 127}, ended)  # 127: libraries were not loaded

    def test_quiet_fits_beyond_the_largest_number(self):
        # Of values whose derivatives are infinite, libraries like to print all.
        draw = random.Random(1)
        rows = "".join(f"{draw.uniform(5, 40)}e150,{draw.uniform(5, 40)}{'' if i % 5 else 'e305'},{i % 6}\n" for i in range(60))
        self.write("huge.csv", "dbh,h,plot\n" + rows)
        for options in ([], ["--random", "a | plot"], ["--variance", "power"]):
            done = self.end_of("fit", "huge.csv", "--formula", "h ~ a*dbh^b", "--quiet", *options)
            for word in ("Logging", "WARNING", ".cc:"):
                self.assertNotIn(word, done.stderr, done.stderr[-1000:])
            self.assertLess(len(done.stderr), 1000)

    def test_a_scene_with_values_of_other_types(self):
        if json.loads(self.run_program("--version", "--json").stdout)["render"] is None:
            self.skipTest("this silvafit draws no pictures")
        for change in ({"scenes": [{"nodes": [0], "extras": {"origin": {"x": "east"}}}]},
                       {"materials": [{"doubleSided": "yes"}]}, {"scenes": [{"nodes": 3}]}):
            scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "materials": [{}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
                     "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
                     "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36}]} | change
            text = json.dumps(scene).encode()
            text += b" " * (-len(text) % 4)
            buffer = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
            body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
            (self.folder / "odd.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)
            done = self.end_of("render", "odd.glb", "--out", "p.png", "--size", "16x16", "--samples", "1")
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("odd.glb: cannot read the glTF scene: ", done.stderr)

    def test_a_description_beside_the_buffer_of_another_scene(self):
        if json.loads(self.run_program("--version", "--json").stdout)["render"] is None:
            self.skipTest("this silvafit draws no pictures")
        for name, trees in (("one", "1"), ("two", "2")):
            self.write(f"{name}.csv", f"plot,tree,species,x,y,dbh,h,hcb,cw\n1,1,SM,1,1,2{trees},15,7,3\n")
            self.run_program("grow", f"{name}.csv", "--scene", f"{name}/s.gltf", "--lod", "3", "--quiet")
        picture = ("--out", "p.png", "--size", "16x16", "--samples", "1")
        self.run_program("render", "one/s.gltf", *picture)
        bytes_of_one = (self.folder / "one" / "s.bin").read_bytes()
        for buffer in ((self.folder / "two" / "s.bin").read_bytes(), bytes_of_one[:-4], bytes_of_one[:-1] + b"\x01"):
            (self.folder / "one" / "s.bin").write_bytes(buffer)
            error = self.run_program("render", "one/s.gltf", *picture, status=3).stderr
            self.assertIn("one/s.gltf", error)
            self.assertIn("its buffer s.bin is not the one that was written with it; write the scene again", error)


if __name__ == "__main__":
    unittest.main()
