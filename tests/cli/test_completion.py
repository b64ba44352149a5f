# SPDX-License-Identifier: MIT
"""Shells complete what --help lists: each command, each option and each value of a short list."""

import os
import shutil
import subprocess
import unittest
from pathlib import Path

from command_line import all_commands, choices_of, commands_below, options_of
from silvafit_program import PROGRAM, ProgramTest

BASH = r"""
source completion
while read -ra COMP_WORDS; do
  [ "${COMP_WORDS[-1]}" = EMPTY ] && COMP_WORDS[-1]=
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  _silvafit
  echo "${COMPREPLY[*]}"
done
"""

# zsh's own functions work in its line editor alone: here they print what they are given.
ZSH = r"""
compdef() { : }
_describe() { print -rl -- "${(P@)2}" }
_files() { print -rl -- FILES }
source completion
while read -rA words; do
  [ "${words[-1]}" = EMPTY ] && words[-1]=
  CURRENT=$#words
  _silvafit
  print END
done
"""


class Completion(ProgramTest):
    def setUp(self):
        super().setUp()
        self.commands = list(all_commands())
        self.assertGreater(len(self.commands), 10)

    def shell(self, *arguments, text=""):
        done = subprocess.run(
            arguments,
            cwd=self.folder,
            env={**os.environ, "PATH": f"{Path(PROGRAM).parent}:{os.environ['PATH']}"},
            input=text,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        self.assertEqual((done.returncode, done.stderr), (0, ""), arguments)
        return done.stdout

    def completion(self, name):
        if not shutil.which(name):
            self.skipTest(f"{name} is not installed")
        return self.write("completion", self.run_program("completion", name).stdout)

    def bash(self, lines):
        """For each line of words, of which the last is to be completed: what is offered."""
        typed = "".join(" ".join(("silvafit", *words)) + "\n" for words in lines)
        return [line.split() for line in self.shell("bash", "-c", BASH, text=typed).splitlines()]

    def test_bash_completes_each_option_of_each_command(self):
        self.completion("bash")
        offered = self.bash([(*command, "-") for command in self.commands])
        for command, words in zip(self.commands, offered, strict=True):
            self.assertEqual(sorted(words), sorted(options_of(command)), command)

    def test_bash_completes_commands(self):
        self.completion("bash")
        with_commands = [command for command in self.commands if commands_below(command)]
        offered = self.bash([(*command, "EMPTY") for command in with_commands])
        for command, words in zip(with_commands, offered, strict=True):
            listed = [word for word in words if not word.startswith("-")]
            self.assertEqual(listed, commands_below(command), command)

    def test_bash_completes_values_in_both_spellings(self):
        self.completion("bash")
        lines, expected = [], []
        for command in self.commands:
            for option, choices in choices_of(command).items():
                lines += [(*command, option, "EMPTY"), (*command, option, "=", choices[0][:1])]
                expected += [choices, [word for word in choices if word[0] == choices[0][0]]]
        self.assertGreater(len(lines), 20)
        self.assertEqual(self.bash(lines), expected)

    def test_bash_takes_an_argument_that_is_called_like_a_command_for_an_argument(self):
        self.completion("bash")
        offered = self.bash([("fit", "study", "--formu"), ("fit", "--formula", "EMPTY")])
        self.assertEqual(offered, [["--formula"], []])

    def zsh(self, lines):
        """For each line of words: what is offered, with its meaning."""
        typed = "".join(" ".join(("silvafit", *words)) + "\n" for words in lines)
        printed = self.shell("zsh", "-f", "-c", ZSH, text=typed)
        return [part.splitlines() for part in printed.split("END\n")[:-1]]

    def test_zsh_completes_each_option_of_each_command(self):
        self.completion("zsh")
        offered = self.zsh([(*command, "-") for command in self.commands])
        for command, lines in zip(self.commands, offered, strict=True):
            self.assertEqual(sorted(line.split(":")[0] for line in lines), sorted(options_of(command)), command)
            self.assertNotIn("", [line.split(":")[1] for line in lines], command)

    def test_zsh_completes_values_in_both_spellings_and_else_files(self):
        self.completion("zsh")
        lines, expected = [("fit", "EMPTY"), ("fit", "--formula", "EMPTY")], [["FILES"], ["FILES"]]
        for command in self.commands:
            for option, choices in choices_of(command).items():
                lines += [(*command, option, "EMPTY"), (*command, f"{option}={choices[0]}")]
                expected += [[f"{word}:" for word in choices]]
                expected += [[f"{option}={word}:" for word in choices if word.startswith(choices[0])]]
        self.assertEqual(self.zsh(lines), expected)

    def test_fish_completes_each_option_of_each_command(self):
        self.completion("fish")
        for command in self.commands:
            typed = " ".join(("silvafit", *command, "--"))
            script = f"source completion; complete --do-complete '{typed}'"
            printed = self.shell("fish", "--no-config", "-c", script)
            words = [line.split("\t")[0] for line in printed.splitlines()]
            wanted = [name for name in options_of(command) if name.startswith("--")]
            self.assertEqual(sorted(words), sorted(wanted), command)

    def test_fish_completes_files_where_no_word_is_offered(self):
        self.completion("fish")
        self.write("inventory.csv", "")
        script = "source completion; complete --do-complete 'silvafit study inv'"
        self.assertEqual(self.shell("fish", "--no-config", "-c", script).split("\t")[0].strip(), "inventory.csv")

    def test_as_json_the_script_is_a_text(self):
        result = self.run_json("completion", "bash")
        self.assertEqual(result["shell"], "bash")
        self.assertEqual(result["script"], self.run_program("completion", "bash").stdout)

    def test_an_unknown_shell_is_wrong_usage(self):
        self.run_program("completion", "tcsh", status=2)


if __name__ == "__main__":
    unittest.main()
