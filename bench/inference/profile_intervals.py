#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Times profile intervals of a Laplace fit with two random effects: 10 000 trees on 200 plots.

Usage: bench/inference/profile_intervals.py [PROGRAM]   (default build/bin/silvafit)
Prints seconds of the fit alone, and of the fit with Wald and with profile intervals, reading the file included: elapsed, and of all
processors together, which other work on the machine hardly changes. The least of three.
"""

import math
import pathlib
import random
import resource
import subprocess
import sys
import tempfile
import time

PLOTS = 200
TREES = 50


def write_trees(path):
    draw = random.Random(17)
    with open(path, "w", encoding="ascii") as file:
        file.write("plot,dbh,h\n")
        for plot in range(PLOTS):
            shared = draw.gauss(0, 1)
            a = 30 + 3 * shared
            b = 0.05 + 0.006 * (0.4 * shared + math.sqrt(1 - 0.16) * draw.gauss(0, 1))
            for _ in range(TREES):
                dbh = draw.uniform(5, 50)
                mean = 1.3 + a * (1 - math.exp(-b * dbh))
                file.write(f"{plot + 1},{dbh:.3f},{mean + 0.4 * mean**0.5 * draw.gauss(0, 1):.4f}\n")


def seconds(program, trees, variance, threads, intervals):
    command = [program, "fit", trees, "--formula", "h ~ 1.3 + a*(1 - exp(-b*dbh))", "--random", "a + b | plot",
               "--method", "laplace", "--variance", variance, "--threads", str(threads), "--json"]
    if intervals:
        command += ["--intervals", intervals]
    elapsed = []
    processor = []
    for _ in range(3):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        begin = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        elapsed.append(time.perf_counter() - begin)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        processor.append(after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)
    return min(elapsed), min(processor)


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "build/bin/silvafit"
    with tempfile.TemporaryDirectory() as folder:
        trees = str(pathlib.Path(folder) / "trees.csv")
        write_trees(trees)
        print("variance  threads  fit alone: elapsed, processor  with Wald  with profile")
        for variance in ("none", "power"):
            for threads in (1, 2):
                row = [seconds(program, trees, variance, threads, kind) for kind in (None, "wald", "profile")]
                print(f"{variance:8}  {threads:7}  " + "  ".join(f"{wall:9.3f} {cpu:7.3f}" for wall, cpu in row))


if __name__ == "__main__":
    main()
