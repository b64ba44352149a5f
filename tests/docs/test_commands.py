# SPDX-License-Identifier: MIT
"""Every command in the documentation runs, in the order of its page, and answers what the page shows.

Pictures are drawn small, whatever their size on the page: nothing but their size and their noise depends on it.
"""

import collections
import concurrent.futures
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from pages import Command, commands
from readers_files import Reader

SOURCE = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ["SILVAFIT_PROGRAM"])
PAGES = [SOURCE / "README.md", *sorted((SOURCE / "docs").rglob("*.md")), *sorted((SOURCE / "examples").glob("*/README.md"))]
PAGES.insert(1, SOURCE / "CONTRIBUTING.md")

# Other programs that a page may use between two commands of ours; they change nothing outside of the folder.
TOOLS = {"silvafit", "build/bin/silvafit", "head", "tail", "cut", "wc", "ls", "cat", "cp", "mkdir", "grep", "sort", "awk",
         "printf", "source", "export", "python3", "for"}


def small_picture(text):
    """A command that draws a picture, with few rays."""
    if not re.match(r"(build/bin/)?silvafit render ", text):
        return text
    text = re.sub(r" --(size|samples) \S+", "", text)
    return re.sub(r"( *#.*)?$", " --size 96x64 --samples 1", text, count=1)


def first_word(command):
    return command.split()[0]


def comparable(line):
    """Seconds, rates and blanks at the end differ between runs."""
    line = re.sub(r"\d+(\.\d+)? s\b", "# s", line.rstrip())
    return re.sub(r"\d+ a second", "# a second", line)


def missing_lines(shown, answer):
    """The lines of a page that the answer does not have in their order. A line of dots stands for any lines."""
    came = [comparable(line) for line in answer.splitlines()]
    missing, at = [], 0
    for line in map(comparable, shown):
        if not line or line == "...":
            continue
        if line in came[at:]:
            at = came.index(line, at) + 1
        else:
            missing.append(line)
    return missing


def wrong_names(text):
    """What a command that is not run here takes for granted: targets of make, and files of the checkout."""
    words = text.split("#")[0].split()
    if words[0] == "make":
        done = subprocess.run(["make", "--dry-run", *words[1:]], cwd=SOURCE, capture_output=True, text=True, check=False)
        return done.stderr
    files = [word for word in words if re.match(r"(scripts|bench|tests|examples)/", word)]
    return "".join(f"there is no {name}\n" for name in files if not (SOURCE / name).exists())


class Folder:
    """A folder like the checkout's, as far as commands look at it."""

    def __init__(self, path):
        self.path = Path(path)
        (self.path / "build/bin").mkdir(parents=True)
        (self.path / "build/bin/silvafit").symlink_to(PROGRAM)
        # A copy, since commands may write beside what they read.
        shutil.copytree(SOURCE / "examples", self.path / "examples")
        (self.path / "tests").symlink_to(SOURCE / "tests")
        self.environment = os.environ | {"PATH": f"{self.path}/build/bin:{os.environ['PATH']}", "LC_ALL": "C.UTF-8"}

    def run(self, text):
        return subprocess.run(["bash", "-o", "pipefail", "-c", text], cwd=self.path, env=self.environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600, check=False)

    def prepare(self, text):
        done = self.run(text)
        if done.returncode != 0:
            raise RuntimeError(f"{text}\n{done.stdout}")


class Page:
    """A page, followed in a folder of its own by a reader who has the files that it speaks of."""

    def __init__(self, path, folder, reader):
        self.commands = list(commands(str(path.relative_to(SOURCE)), path.read_text(encoding="utf-8")))
        self.folder = Folder(folder)
        self.reader = reader

    def follow(self):
        """(command, why it was not run, what was wrong, seconds) for each command."""
        for command in self.commands:
            started = time.monotonic()
            reason, fault = self.try_out(command)
            yield command, reason, fault, time.monotonic() - started

    def try_out(self, command: Command):
        if command.reason_not_to_run:
            return command.reason_not_to_run, ""
        if first_word(command.text) not in TOOLS:
            return f"{first_word(command.text)}, of which names are looked at", wrong_names(command.text)
        self.reader.provide(command.text, self.folder.path)
        done = self.folder.run(small_picture(command.text))
        if done.returncode != command.status:
            return "", f"status {done.returncode} instead of {command.status}:\n{done.stdout}"
        missing = missing_lines(command.answer, done.stdout)
        if missing:
            return "", "the page shows lines that did not come:\n" + "\n".join(missing) + f"\nCame:\n{done.stdout}"
        return "", ""


def follow_all(pages):
    """The results of all pages, several at a time, each page in the order of its commands."""
    with tempfile.TemporaryDirectory(prefix="silvafit-docs-") as folder:
        home = Folder(Path(folder) / "reader")
        reader = Reader(home.path, home.prepare)
        follow = lambda page: list(Page(page, Path(folder) / str(PAGES.index(page)), reader).follow())
        with concurrent.futures.ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            return [result for results in pool.map(follow, pages) for result in results]


class Documentation(unittest.TestCase):
    def test_every_command_runs(self):
        results = follow_all(PAGES)
        not_run = collections.Counter()
        slow = sorted(results, key=lambda result: -result[3])[:12]
        faults = []
        for command, reason, fault, _ in results:
            if reason:
                not_run[f"{command.page}: {reason}"] += 1
            if fault:
                faults.append(f"{command.page}:{command.line}: {command.text}\n{fault}")
        run = len(results) - sum(not_run.values())
        print(f"{run} commands of {len(PAGES)} pages ran, {sum(not_run.values())} did not:", file=sys.stderr)
        for reason, count in sorted(not_run.items()):
            print(f"  {count} {reason}", file=sys.stderr)
        for command, _, _, seconds in slow:
            print(f"  {seconds:5.1f} s {command.page}:{command.line}: {command.text[:80]}", file=sys.stderr)
        self.assertEqual(faults, [], "\n\n".join(faults))
        # The pages have more than a hundred commands; far fewer would mean that they were not found.
        self.assertGreater(run, 80)


class Reading(unittest.TestCase):
    PAGE = """# A page

    silvafit fit a.csv \\
      --json > fit.json
    head fit.json    # a look at it

Something else:

    a_program of its own

<!-- not run: takes a day -->

    silvafit study b.csv --out b

```console
$ silvafit models M1
M1 Naslund
...
$ silvafit models M2
```

<!-- status: 4 -->
```
silvafit fit c.csv     no model converges
```

```json
silvafit fit d.csv
```
"""

    def test_commands_are_found_with_what_is_said_of_them(self):
        found = [(c.line, c.text, c.reason_not_to_run, c.status, c.answer) for c in commands("page", self.PAGE)]
        self.assertEqual(found, [
            (3, "silvafit fit a.csv --json > fit.json", "", 0, []),
            (5, "head fit.json", "", 0, []),
            (13, "silvafit study b.csv --out b", "takes a day", 0, []),
            (16, "silvafit models M1", "", 0, ["M1 Naslund", "..."]),
            (19, "silvafit models M2", "", 0, []),
            (24, "silvafit fit c.csv", "", 4, []),
        ])

    def test_answers_are_compared_line_by_line_but_for_times(self):
        answer = "one\ntwo\n3 fits in 1.5 s, 10 a second\nfour\n"
        self.assertEqual(missing_lines(["one", "...", "3 fits in 0.9 s, 7 a second"], answer), [])
        self.assertEqual(missing_lines(["two", "one"], answer), ["one"])
        self.assertEqual(missing_lines(["4 fits in 1.5 s, 10 a second"], answer), ["4 fits in # s, # a second"])


if __name__ == "__main__":
    unittest.main()
