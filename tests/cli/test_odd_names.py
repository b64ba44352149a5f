# SPDX-License-Identifier: MIT
"""Names of files and words of the command line may hold any bytes, and names in files any characters."""

import csv
import json
import os
import pty
import subprocess
import unittest
from pathlib import Path

from silvafit_program import PROGRAM, ProgramTest

EXAMPLE = Path(__file__).parents[2] / "examples" / "fir-mixed" / "inventory.csv"
NOT_UTF8 = b"n\xff.csv"
SHOWN = "n\ufffd.csv"


class NotUtf8(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / os.fsdecode(NOT_UTF8)).write_bytes(EXAMPLE.read_bytes())

    def run_bytes(self, *arguments):
        """Standard output, which must be UTF-8."""
        done = subprocess.run([os.fsencode(PROGRAM), *arguments], cwd=self.folder, capture_output=True, timeout=280,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.decode("utf-8")

    def text(self, name):
        return (self.folder / name).read_text(encoding="utf-8")

    def test_a_study_of_a_file_whose_name_is_not_utf8(self):
        done = json.loads(self.run_bytes(b"study", NOT_UTF8, b"--species", b"SM", b"--responses", b"h",
                                         b"--out", b"out\xff", b"--json"))
        self.assertEqual(done["out"], "out\ufffd")
        folder = self.folder / os.fsdecode(b"out\xff")
        self.assertEqual(json.loads((folder / "run.json").read_text(encoding="utf-8"))["input"]["file"], SHOWN)
        self.assertEqual(json.loads((folder / "library.json").read_text(encoding="utf-8"))["inventory"]["file"], SHOWN)
        report = (folder / "report.html").read_text(encoding="utf-8")
        self.assertIn(f"<title>silvafit: {SHOWN}</title>", report)
        # The library is one that other commands read, and the page of two libraries names the files.
        self.run_bytes(b"predict", b"out\xff/library.json", NOT_UTF8, b"--out", b"p\xff.csv", b"--json")
        (self.folder / os.fsdecode(b"b\xff.json")).write_bytes((folder / "library.json").read_bytes())
        compared = json.loads(self.run_bytes(b"compare", b"out\xff/library.json", b"b\xff.json", b"--html", b"c.html",
                                             b"--json"))
        self.assertIn("b\ufffd.json", json.dumps(compared, ensure_ascii=False))
        self.assertIn("b\ufffd.json", self.text("c.html"))

    def test_indices_and_stand_say_the_name_as_far_as_it_is_text(self):
        for command in (b"indices", b"stand"):
            self.assertEqual(json.loads(self.run_bytes(command, NOT_UTF8, b"--json"))["inventory"], SHOWN)

    def test_a_view_of_a_file_whose_name_and_title_are_not_utf8(self):
        done = json.loads(self.run_bytes(b"view", NOT_UTF8, b"--no-open", b"--json"))
        self.assertEqual(done["page"], "n\ufffd.html")
        self.run_bytes(b"view", NOT_UTF8, b"--no-open", b"--title", b"S\xc3\xa9ne\xff", b"--out", b"titled.html")
        self.assertIn("<title>S\u00e9ne\ufffd</title>", self.text("titled.html"))


class ControlCharacters(ProgramTest):
    ESCAPE = "S\x1b[2JM"

    def stderr(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=60,
                              check=False)
        self.assertNotIn("internal error", done.stderr)
        return done.stderr

    def test_a_species_cannot_move_the_cursor_of_who_reads_an_error(self):
        # Two trees of one name: the message says whose.
        self.write("trees.csv", "plot,tree,species,x,y,dbh\n" + f"{self.ESCAPE},{self.ESCAPE},SM,1,1,10\n" * 2)
        said = self.stderr("indices", "trees.csv")
        self.assertIn("S\\x1b[2JM", said)
        self.assertNotIn("\x1b", said)

    def test_a_species_cannot_move_the_cursor_of_who_reads_a_note(self):
        rows = "".join(f"1,{t},{self.ESCAPE},{t % 3},{t // 3},{10 + t},{8 + t}\n" for t in range(9))
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h\n" + rows)
        said = self.stderr("study", "trees.csv", "--out", "out")
        self.assertIn("S\\x1b[2JM", said)
        self.assertNotIn("\x1b", said)

    def test_a_name_cannot_turn_the_direction_of_a_message_or_table(self):
        name = "oak\u202egnp.exe"
        rows = "".join(f"1,{t},{name},{t % 3},{t // 3},{10 + t},{8 + t}\n" for t in range(9))
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h\n" + rows)
        for arguments in (["study", "trees.csv", "--out", "out"], ["stand", "trees.csv"], ["stand", "trees.csv", "--json"]):
            done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=60, check=False)
            self.assertIn("oak\\u202egnp.exe", done.stdout + done.stderr)
            self.assertNotIn("\u202e", done.stdout + done.stderr)
            if "--json" in arguments:
                self.assertIn(name, json.dumps(json.loads(done.stdout), ensure_ascii=False))

    def test_a_table_on_a_terminal_shows_controls_and_a_file_has_them(self):
        rows = "".join(f"1,{t},{self.ESCAPE},{t % 3},{t // 3},{10 + t}\n" for t in range(9))
        self.write("trees.csv", "plot,tree,species,x,y,dbh\n" + rows)
        terminal, end = pty.openpty()
        subprocess.run([PROGRAM, "indices", "trees.csv", "--quiet"], cwd=self.folder, stdout=end, timeout=60, check=True)
        os.close(end)
        shown = os.read(terminal, 1 << 16).decode("utf-8")
        os.close(terminal)
        self.assertIn("S\\x1b[2JM", shown)
        self.assertNotIn("\x1b", shown)
        self.assertIn(self.ESCAPE, self.run_program("indices", "trees.csv", "--quiet").stdout)


class Formulas(ProgramTest):
    """Names that a spreadsheet would compute have an apostrophe in files and none where files are read."""

    NAMES = ["=1+1", "@A1", "+oak", "-oak", "'=1"]

    def setUp(self):
        super().setUp()
        rows = "".join(f"p,{t},\"{name}\",{3 * t},{s},{10 + t},{8 + t},-1.5\n"
                       for s, name in enumerate(["=1+1", "@A1", "+oak", "-oak", "''=1"]) for t in range(5 * s, 5 * s + 5))
        self.write("trees.csv", "plot,tree,species,x,y,dbh,h,t\n" + rows)

    def species(self, name):
        with open(self.folder / name, encoding="utf-8", newline="") as file:
            return [row["species"] for row in csv.DictReader(file)]

    def test_names_stay_the_same_when_results_are_read_again(self):
        written = [name for name in ["'=1+1", "'@A1", "'+oak", "'-oak", "''=1"] for _ in range(5)]
        self.run_program("indices", "trees.csv", "--out", "i.csv", "--quiet")
        self.assertEqual(self.species("i.csv"), written)
        filled = ("impute", "--response", "h", "--formula", "h ~ 1.3 + a*dbh^b", "--random", "none", "--out")
        self.run_program(*filled, "first.csv", "trees.csv", "--quiet")
        self.assertEqual(self.species("first.csv"), written)
        self.assertIn(",-1.5,", (self.folder / "first.csv").read_text(encoding="utf-8"))
        stand = self.run_json("stand", "first.csv", "--case-sensitive")
        self.assertEqual({row["species"] for row in stand["species"]}, {*self.NAMES})


if __name__ == "__main__":
    unittest.main()
