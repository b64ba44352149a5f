# SPDX-License-Identifier: MIT
"""What --help-all says that the program takes: commands, and the options of each."""

import re
import subprocess

from silvafit_program import PROGRAM


def help_of(*words):
    return subprocess.run([PROGRAM, *words, "--help-all"], capture_output=True, text=True, check=True).stdout


def section(text, heading):
    """The lines below a heading, up to the next one."""
    found = re.search(rf"^{heading}:\n((?:  .*\n|\n(?=  ))*)", text, re.MULTILINE)
    return found.group(1).splitlines() if found else []


def commands_below(words):
    lines = section(help_of(*words), "Subcommands")
    return [match.group(1) for line in lines if (match := re.match(r"  ([a-z]\S*)", line))]


def options_of(words):
    """The names of all options, short ones included."""
    names = []
    for line in help_of(*words).splitlines():
        match = re.match(r"  (-\S*)", line)
        if match:
            names += re.findall(r"--?[a-z][a-z-]*", match.group(1).split(":")[0])
    return names


def choices_of(words):
    """By option: the values that it is limited to."""
    found = {}
    for line in help_of(*words).splitlines():
        match = re.match(r"  (?:-\w,)?(--[a-z-]+) \w+:\{([^}]*)\}", line)
        if match:
            found[match.group(1)] = match.group(2).split(",")
    return found


def all_commands(words=()):
    """Every command as a tuple of words, () for the program itself."""
    yield words
    for below in commands_below(words):
        yield from all_commands((*words, below))
