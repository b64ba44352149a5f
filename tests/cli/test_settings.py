# SPDX-License-Identifier: MIT
"""Each setting of docs/settings.md is an option of the commands that the page names, and --help is a part of --help-all."""

import re
import subprocess
import unittest
from pathlib import Path

from command_line import all_commands, options_of
from silvafit_program import PROGRAM, ProgramTest

PAGE = Path(__file__).parents[2] / "docs" / "settings.md"


def sections():
    """Of each list: the commands, and the options of the settings that have one."""
    for text in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        commands = re.findall("`([^`]+)`", re.search("^- program: (.*)$", text, re.MULTILINE)[1])
        yield commands, re.findall(r"^\| `[^`]+` \| `(--[^`]+)` ", text, re.MULTILINE)


def shown(*words):
    text = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r"^  (?:-\w,)?(--[a-z-]+)", text, re.MULTILINE)), text


class Settings(ProgramTest):
    def test_every_setting_is_an_option(self):
        checked = 0
        for commands, options in sections():
            self.assertTrue(options)
            for command in commands:
                self.assertEqual(set(options) - set(options_of(command.split())), set(), command)
                checked += len(options)
        self.assertGreater(checked, 150)

    def test_help_of_commands_with_many_options_is_short(self):
        for words in all_commands():
            few, text = shown(*words, "--help")
            everything, _ = shown(*words, "--help-all")
            self.assertLessEqual(few, everything, words)
            self.assertLessEqual(len(few), 20, words)
            left_out = re.search(r"^(\d+) more options: silvafit (.*) --help-all$", text, re.MULTILINE)
            self.assertEqual(int(left_out[1]) if left_out else 0, len(everything - few), words)
            if left_out:
                self.assertEqual(left_out[2].split(), list(words))


if __name__ == "__main__":
    unittest.main()
