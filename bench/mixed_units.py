#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws inventories in cm and m, changes the units of some plots, and counts the plots that silvafit names.

mixed_units.py PROGRAM [--inventories 200] [--seed 2]

Heights are a (1 - exp(-b dbh))^c above breast height, for twelve kinds of stands from thickets to old redwoods. Sites differ in height by a
standard deviation of 8 to 20 %, trees of a plot by 8 %. Trees above 10 m have h/dbh of at most 200. docs/inventory.md has the results.
"""

import argparse
import math
import random
import re
import subprocess
import tempfile
from pathlib import Path

# Asymptote [m], rate [1/cm], shape, and the range of the diameters [cm].
KINDS = {"boreal": (22, .06, 1.1, (5, 35)), "spruce": (38, .045, 1.15, (8, 60)), "mountain": (18, .035, 1.0, (6, 70)),
         "tropical": (42, .03, .9, (10, 120)), "eucalypt": (34, .045, 1.05, (6, 30)), "dryland": (9, .05, .9, (5, 40)),
         "poplar": (30, .05, 1.15, (10, 45)), "thicket": (12, .14, 1.0, (1.5, 9)), "redwood": (80, .02, 1.0, (20, 220)),
         "shrub": (5, .2, .9, (1, 8)), "fir": (26, .05, 1.1, (6, 45)), "pollard": (8, .2, 1.0, (30, 120))}
# Factors of dbh and h.
UNITS = {"dbh in mm": (10, 1), "dbh in inches": (1 / 2.54, 1), "h in feet": (1, 1 / .3048), "inches and feet": (1 / 2.54, 1 / .3048),
         "h in dm": (1, 10), "h in cm": (1, 100)}


def inventory(draw):
    """A list of plots, each a list of (kind, dbh, h or None)."""
    kinds = draw.sample(sorted(KINDS), draw.choice([1, 1, 2, 3]))
    stage_spread = draw.choice([.1, .3, .6])
    plots = []
    for _ in range(draw.randint(4, 40)):
        site, stage = math.exp(draw.gauss(0, draw.choice([.08, .15, .2]))), draw.random()
        stocking = math.exp(draw.gauss(0, .15))
        trees = []
        for _ in range(draw.randint(4, 50)):
            kind = draw.choice(kinds)
            a, b, c, (low, high) = KINDS[kind]
            mean = low + (high - low) * (stage * stage_spread + (1 - stage_spread) * .4)
            dbh = max(low * .6, draw.gauss(mean, mean * draw.choice([.15, .3])))
            h = 1.3 + site * a * (1 - math.exp(-b * dbh * stocking)) ** c * math.exp(draw.gauss(0, .08))
            trees.append((kind, dbh, min(h, max(10, 2 * dbh)) if draw.random() < .9 else None))
        plots.append(trees)
    return plots


def named_plots(program, path, plots, changed, factors):
    """The plots that the program says are in other units."""
    with path.open("w", encoding="utf-8") as file:
        file.write("plot,tree,species,dbh,h\n")
        for plot, trees in enumerate(plots):
            of_dbh, of_h = factors if plot in changed else (1, 1)
            for tree, (kind, dbh, h) in enumerate(trees):
                file.write(f"{plot},{tree},{kind},{dbh * of_dbh:.1f},{'' if h is None else f'{h * of_h:.1f}'}\n")
    said = subprocess.run([program, "impute", path, "--response", "h", "--model", "M1", "--random", "none", "--out", "/dev/null", "--quiet"],
                          capture_output=True, text=True, check=False).stderr
    named = re.findall(r"in plots? ([\d, ]+(?:and \d+ more)?)", said) if "mixes units" in said else []
    return {int(number) for text in named for number in re.findall(r"\d+", text.split(" and ")[0])}


def main():
    parser = argparse.ArgumentParser(description="Counts plots in other units that are found, and false alarms.")
    parser.add_argument("program")
    parser.add_argument("--inventories", type=int, default=200)
    parser.add_argument("--seed", type=int, default=2)
    arguments = parser.parse_args()
    all_plots, alarms = 0, []
    found, asked = dict.fromkeys(UNITS, 0), dict.fromkeys(UNITS, 0)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "inventory.csv"
        for number in range(arguments.inventories):
            draw = random.Random(f"{arguments.seed}-{number}")
            plots = inventory(draw)
            all_plots += len(plots)
            alarms += [f"{number}/{plot}" for plot in sorted(named_plots(arguments.program, path, plots, set(), (1, 1)))]
            for name, factors in UNITS.items():
                changed = set(draw.sample(range(len(plots)), max(1, len(plots) // 10)))
                asked[name] += len(changed)
                found[name] += len(changed & named_plots(arguments.program, path, plots, changed, factors))
    print(f"{len(alarms)} false alarms in {all_plots} plots of {arguments.inventories} inventories (inventory/plot: {', '.join(alarms) or 'none'})")
    for name in UNITS:
        print(f"{name:16} {found[name]} of {asked[name]} plots found")


if __name__ == "__main__":
    main()
