#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures strong scaling over threads and over processes of MPI: the same work with 1, 2, ... workers.

scaling.py PROGRAM [--workers 1,2] [--trees 10000000] [--repeat 3] [--only laplace,study] [--folder DIR]

PROGRAM is a silvafit with MPI (make mpi). Efficiency is the elapsed time of one worker over n times that of n workers, of the fastest of the
repetitions; processor time over that of one worker shows what the parallel runs do more. Memory is that of the largest process. Run it on an idle
machine. docs/large-inventories.md has the results.
"""

import argparse
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MEYER = "h ~ 1.3 + a*(1 - exp(-b*dbh))"
MPIRUN = ["mpirun", "--oversubscribe", "--allow-run-as-root", "--bind-to", "none"]


def write_heights(path, trees, trees_of_plot=20, seed=6):
    """Heights of Meyer curves whose limit and rate differ between plots."""
    draw = random.Random(seed)
    with path.open("w", encoding="utf-8") as file:
        file.write("plot,tree,dbh,h\n")
        for plot in range(1, trees // trees_of_plot + 1):
            limit, rate = 25 + draw.gauss(0, 2), .06 * math.exp(draw.gauss(0, .1))
            rows = []
            for tree in range(1, trees_of_plot + 1):
                dbh = round(8 + 40 * draw.random(), 1)
                rows.append(f"{plot},{tree},{dbh},{1.3 + limit * (1 - math.exp(-rate * dbh)) + draw.gauss(0, .8):.2f}\n")
            file.write("".join(rows))


def write_positions(path, trees, trees_of_plot=50, seed=5):
    """Trees at random places of plots of 31 m."""
    draw = random.Random(seed)
    with path.open("w", encoding="utf-8") as file:
        file.write("plot,tree,species,x,y,dbh\n")
        for plot in range(1, trees // trees_of_plot + 1):
            file.write("".join(f"{plot},{tree},{draw.choice(('fir', 'oak'))},{31 * draw.random():.2f},{31 * draw.random():.2f},"
                               f"{8 + 40 * draw.random():.1f}\n" for tree in range(1, trees_of_plot + 1)))


def run(command, folder):
    """Elapsed and processor seconds and the largest process in MB; children of mpirun count."""
    begin = time.monotonic()
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        error = process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {error.decode()}")
    return time.monotonic() - begin, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def cases(program, trees):
    """Name, file that is needed, command, and whether threads and processes share its work."""
    inventory = Path(__file__).resolve().parents[2] / "examples/fir-mixed/inventory.csv"
    laplace = [program, "fit", "heights.csv", "--formula", MEYER, "--random", "a + b | plot", "--method", "laplace", "--json"]
    return {
        "laplace, 1e6 trees": ("heights.csv", 10**6, [*laplace], True, False),
        "laplace, 1e6 trees, --share-groups": ("heights.csv", 10**6, [*laplace, "--share-groups"], True, True),
        "study of fir-mixed": (None, 0, [program, "study", inventory, "--out", "study", "--quiet"], True, True),
        "500 bootstraps, 2000 trees": ("few.csv", 2000, [program, "fit", "few.csv", "--formula", MEYER, "--random", "a | plot", "--bootstrap",
                                                         "500", "--json"], True, True),
        f"indices --stream, {trees:.0e} trees": ("positions.csv", trees, [program, "indices", "positions.csv", "--stream", "--edge", "none",
                                                                        "--out", "indices.csv"], True, False),
    }


def measure(name, case, workers, repeat, folder):
    _, _, command, has_threads, has_ranks = case
    ways = [("threads", lambda n: [*command, "--threads", str(n)])] if has_threads else []
    if has_ranks and shutil.which("mpirun"):
        ways.append(("processes", lambda n: [*MPIRUN, "-n", str(n), *command, "--threads", "1"]))
    for way, of in ways:
        first = None
        for count in workers:
            runs = [run(of(count), folder) for _ in range(repeat)]
            elapsed, processor = min(one[0] for one in runs), min(one[1] for one in runs)
            memory = max(one[2] for one in runs)
            first = first or (elapsed, processor, count)
            efficiency = first[0] * first[2] / (elapsed * count)
            print(f"| {name} | {count} {way} | {elapsed:.2f} | {processor:.2f} | {processor / first[1]:.2f} | {100 * efficiency:.0f} % | "
                  f"{memory:.0f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda text: Path(text).resolve())
    parser.add_argument("--workers", default="1,2", type=lambda text: [int(word) for word in text.split(",")])
    parser.add_argument("--trees", type=int, default=10**7, help="of the indices")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--only", default="", help="cases whose names begin so, separated by commas")
    parser.add_argument("--folder", type=Path, help="keeps the files of the cases here")
    chosen = parser.parse_args()
    # Processes of one machine exchange through its memory.
    os.environ.update({"OMPI_MCA_btl": "self,vader", "OMPI_MCA_btl_vader_single_copy_mechanism": "none", "OMPI_MCA_plm": "isolated"})
    with tempfile.TemporaryDirectory(prefix="silvafit-scaling-") as temporary:
        folder = chosen.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
        print("| work | workers | elapsed s | processor s | to one | efficiency | MB a process |\n|---|---|---|---|---|---|---|")
        for name, case in cases(chosen.program, chosen.trees).items():
            if chosen.only and not name.startswith(tuple(chosen.only.split(","))):
                continue
            file, trees = case[0], case[1]
            if file and not (folder / file).exists():
                (write_positions if file == "positions.csv" else write_heights)(folder / file, trees)
            measure(name, case, chosen.workers, chosen.repeat, folder)


if __name__ == "__main__":
    main()
