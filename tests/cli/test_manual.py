# SPDX-License-Identifier: MIT
"""Manual pages: one a command, with every option, and nothing that man would complain of."""

import re
import shutil
import subprocess
import unittest

from command_line import all_commands, help_of, options_of
from silvafit_program import ProgramTest


class Manual(ProgramTest):
    def setUp(self):
        super().setUp()
        self.run_program("manual", "--out", "man1")
        self.pages = {path.stem: path for path in (self.folder / "man1").iterdir()}

    def rendered(self, page):
        done = subprocess.run(
            ["man", "--warnings", "-l", str(self.pages[page])],
            env={"PATH": "/usr/bin:/bin", "LC_ALL": "C.UTF-8", "MANWIDTH": "100", "MANROFFOPT": "-c"},
            capture_output=True,
            text=True,
            check=True,
        )
        self.assertEqual(done.stderr, "", page)
        return re.sub(r".\x08", "", done.stdout)

    def test_each_command_has_a_page(self):
        wanted = {"-".join(("silvafit", *words[:1])) for words in all_commands()}
        self.assertEqual(set(self.pages), wanted)

    def test_as_json_the_pages_are_named(self):
        result = self.run_json("manual", "--out", "man1")
        self.assertEqual(set(result["files"]), {path.name for path in self.pages.values()})

    def test_man_shows_every_option_and_example(self):
        if not shutil.which("man"):
            self.skipTest("man is not installed")
        for words in all_commands():
            page = self.rendered("-".join(("silvafit", *words[:1])))
            for option in options_of(words):
                self.assertRegex(page, rf"(?m)^ *(-h, )?{option}(?![a-z-])", words)
            help_text = help_of(*words)
            if "Example:\n" in help_text:
                for line in help_text.split("Example:\n")[1].splitlines():
                    # Long lines are broken, wherever the page ends.
                    wanted = re.sub(r"\s+", " ", line.strip())
                    self.assertIn(wanted, re.sub(r"\s+", " ", page), words)

    def test_names_are_what_apropos_reads(self):
        for name, path in self.pages.items():
            text = path.read_text(encoding="utf-8").replace("\\-", "-")
            self.assertRegex(text, rf"(?m)^\.SH NAME\n{name} - [A-Z]\S* .*[^.]$")


if __name__ == "__main__":
    unittest.main()
