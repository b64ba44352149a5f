# SPDX-License-Identifier: MIT
"""The commands of a page in Markdown: those in fenced and indented blocks, as a reader would type them.

A comment before a block speaks of the whole block:

    <!-- not run: reason -->      for what a test cannot do
    <!-- status: 4 -->            for a command that ends with another exit status than 0

In a block that starts with ```console, lines after `$ ` are typed and the others are what the program answers. In the
other blocks all lines are typed, or those after `$ ` if there are any. Blocks that say no language have commands if one of
their lines starts with a program of ours.
"""

import re
import shlex
from dataclasses import dataclass, field

FENCE = re.compile(r"^( *)```+(\w*)")
NOTE = re.compile(r"<!-- *(not run|status): *(.*?) *-->")
# What a block of commands has in one of its lines at least: a program of ours, or one that works on the checkout.
PROGRAM = re.compile(r"^(\$ )?((build/bin/)?silvafit(_\w+)?|make|ctest|cmake|Rscript|scripts/\S+|bench/\S+)( |$)")


@dataclass
class Command:
    page: str
    line: int
    text: str
    reason_not_to_run: str = ""
    status: int = 0
    answer: list = field(default_factory=list)  # lines that the page shows; empty: it shows none


def blocks(text):
    """(first line from 1, language, lines, note before the block) of each block of code; indented ones have no language."""
    lines = text.splitlines()
    note = None
    index = 0
    while index < len(lines):
        fence = FENCE.match(lines[index])
        if fence:
            start = index + 1
            index = start
            while index < len(lines) and not lines[index].lstrip().startswith("```"):
                index += 1
            yield start + 1, fence.group(2), [line[len(fence.group(1)):] for line in lines[start:index]], note
            note = None
        elif lines[index].startswith("    ") and (index == 0 or not lines[index - 1].strip()):
            start = index
            while index < len(lines) and (lines[index].startswith("    ") or not lines[index].strip()):
                index += 1
            block = lines[start:index]
            indent = min(len(line) - len(line.lstrip()) for line in block if line.strip())
            yield start + 1, "", [line[indent:] for line in block], note
            note = None
            continue
        elif found := NOTE.search(lines[index]):
            note = found.groups()
        elif lines[index].strip():
            note = None
        index += 1


def is_open(text):
    """Whether a quote has not ended yet, so that the next line belongs to it."""
    try:
        shlex.split(text, comments=True)
    except ValueError:
        return True
    return False


def joined_lines(lines, is_typed):
    """(index, text) with typed lines that end in a backslash or inside of a quote joined to the next."""
    index = 0
    while index < len(lines):
        start, text = index, lines[index]
        while is_typed(lines[start]) and index + 1 < len(lines):
            if text.endswith("\\"):
                text = text[:-1].rstrip() + " " + lines[index + 1].strip()
            elif is_open(text):
                text += "\n" + lines[index + 1]
            else:
                break
            index += 1
        yield start, text
        index += 1


def without_remark(text):
    """What stands three blanks or more behind a command is a remark to the reader."""
    return text if "\n" in text else re.split(r" {3,}", text)[0].strip()


def commands(page, text):
    """The commands of a page in their order; blocks without any are examples of something else."""
    for first, language, lines, note in blocks(text):
        if not language and not any(PROGRAM.match(line) for line in lines):
            continue
        if language not in ("", "console", "sh", "bash"):
            continue
        prompted = language == "console" or any(line.startswith("$ ") for line in lines)
        found = []
        for index, text_of in joined_lines(lines, lambda line: not prompted or line.startswith("$ ")):
            if prompted and not text_of.startswith("$ "):
                if found and language == "console":
                    found[-1].answer.append(text_of)
                continue
            typed = without_remark(text_of.removeprefix("$ "))
            if typed and not typed.startswith("#"):
                found.append(Command(page, first + index, typed))
        for command in found:
            if note and note[0] == "not run":
                command.reason_not_to_run = note[1]
            elif note:
                command.status = int(note[1])
        yield from found
