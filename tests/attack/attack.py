#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the program on changed inputs of all commands, and keeps those after which something is wrong.

attack.py PROGRAM [--seconds 600] [--runs N] [--seed 1] [--jobs 2] [--keep FOLDER] [--only NUMBER]

Run NUMBER of a seed has the same inputs and options on every machine. Each run has limits of processor time and
memory. Exit status 1 if something was found; docs/hardening.md says what is looked for.
"""

import argparse
import collections
import concurrent.futures
import os
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cases
import checks

# Beyond this, a run on inputs as small as these is a fault of its own.
PROCESSOR_SECONDS = 30
WALL_SECONDS = 120
MEMORY = 3 << 30
LARGEST_FILE = 1 << 30


def limit():
    """For the child: what it may use. A file that grows too large is an error of the write."""
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_SECONDS, PROCESSOR_SECONDS + 5))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, LARGEST_FILE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class Attack:
    def __init__(self, program, seed, inputs, keep):
        self.program, self.seed, self.inputs, self.keep = program, seed, inputs, keep

    def run(self, number):
        """One run: the name of the command, its exit status, its processor time and what is wrong."""
        place = Path(tempfile.mkdtemp(prefix="silvafit-attack-"))
        folder = place / "work"
        for name in ("work/out", "home", "tmp"):
            (place / name).mkdir(parents=True)
        name, words = cases.make(self.seed, number, self.inputs, folder)
        # The system takes at most 128 KiB of one argument.
        words = [word[:30000] for word in words]
        before = checks.contents(folder)
        begin = time.monotonic()
        environment = {"PATH": os.environ["PATH"], "HOME": str(place / "home"), "TMPDIR": str(place / "tmp"), "LC_ALL": "C.UTF-8"}
        process = subprocess.Popen([self.program, *words], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, preexec_fn=limit)
        try:
            stdout, stderr = process.communicate(timeout=WALL_SECONDS)
            found = []
        except subprocess.TimeoutExpired:
            process.kill()
            stdout, stderr = process.communicate()
            found = [f"still running after {WALL_SECONDS} s"]
        seconds = time.monotonic() - begin
        found += checks.faults(words, process.returncode, stdout, stderr, folder, before)
        found += [f"left in the folder of {kind}: {path.name}" for kind in ("home", "tmp") for path in (place / kind).iterdir()]
        if found:
            self.store(number, words, found, stderr, folder)
        shutil.rmtree(place)
        return name, process.returncode, seconds, found

    def store(self, number, words, found, stderr, folder):
        """Keeps the inputs of a run with its command."""
        kept = self.keep / f"{self.seed}-{number}"
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(folder, kept)
        shutil.rmtree(kept / "out", ignore_errors=True)
        (kept / "out").mkdir()
        (kept / "stderr").write_bytes(stderr)
        command = shlex.join([self.program, *words])
        (kept / "command").write_text(f"# {'; '.join(found)}\ncd {shlex.quote(str(kept))} && {command}\n", encoding="utf-8", errors="replace")
        print(f"run {number}: {'; '.join(found)}\n  {(kept / 'command').read_text(encoding='utf-8').splitlines()[-1]!r}", flush=True)


def numbers(arguments):
    """The numbers of the runs, until there are as many as asked for or the time is over."""
    if arguments.only is not None:
        yield arguments.only
        return
    end = time.monotonic() + arguments.seconds
    number = 0
    while time.monotonic() < end and number != arguments.runs:
        yield number
        number += 1


def main():
    parser = argparse.ArgumentParser(description="Runs the program on changed inputs of all commands.")
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--runs", type=int, help="the same ones on machines of any speed, if the time is enough")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=Path, default=Path("build/attack"))
    parser.add_argument("--only", type=int)
    arguments = parser.parse_args()
    program = str(Path(arguments.program).resolve())
    arguments.keep.mkdir(parents=True, exist_ok=True)
    statuses, longest, failed = collections.Counter(), {}, 0
    with tempfile.TemporaryDirectory(prefix="silvafit-attack-") as scratch:
        inputs = Path(scratch) / "inputs"
        cases.write_inputs(program, inputs)
        attack = Attack(program, arguments.seed, inputs, arguments.keep.resolve())
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            waiting = set()
            for number in numbers(arguments):
                waiting.add(pool.submit(attack.run, number))
                if len(waiting) < arguments.jobs:
                    continue
                done, waiting = concurrent.futures.wait(waiting, return_when=concurrent.futures.FIRST_COMPLETED)
                for future in done:
                    failed += count(future.result(), statuses, longest)
            for future in waiting:
                failed += count(future.result(), statuses, longest)
    for name in sorted({command for command, _ in statuses}):
        by_status = ", ".join(f"{status}: {runs}" for (command, status), runs in sorted(statuses.items()) if command == name)
        print(f"{name:18} longest {longest[name]:5.1f} s; runs by exit status {by_status}")
    print(f"{sum(statuses.values())} runs of seed {arguments.seed}, {failed} with faults")
    return 1 if failed else 0


def count(result, statuses, longest):
    """Adds a run to the statistics; 1 if it had faults."""
    name, status, seconds, found = result
    statuses[name, status] += 1
    longest[name] = max(longest.get(name, 0), seconds)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
