#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""CPU time of sf.fit() beside that of the C++ fit of the same table, by number of rows.

Usage: PYTHONPATH=build/python bench/python/overhead.py [ROWS ...]

The C++ fit is the call of the extension on a table that is there already: reading the texts of the model, and the fit. The
rest of sf.fit() is conversion of the columns, choice of columns, warnings, and the result. Times are the smallest of several
runs on one thread, so that other work on the machine counts little.
"""
import sys
import time
import warnings

import numpy as np
import pandas as pd

import silvafit as sf
from silvafit import _core
from silvafit._data import frame_of

FORMULA = "h ~ 1.3 + a*(1 - exp(-b*dbh))"


def inventory(rows, seed=1):
    """Plots of 20 trees with text labels, twelve further columns as real inventories have them."""
    random = np.random.default_rng(seed)
    plots = max(2, rows // 20)
    plot = np.arange(rows) % plots
    dbh = random.uniform(5.0, 60.0, rows)
    asymptote = 30.0 + random.normal(0.0, 3.0, plots)[plot]
    h = 1.3 + asymptote * (1.0 - np.exp(-0.05 * dbh)) + random.normal(0.0, 1.0, rows)
    trees = pd.DataFrame({"plot": np.char.add("P", plot.astype(str)).astype(object), "dbh": dbh, "h": h})
    for number in range(12):
        trees[f"further{number}"] = random.normal(size=rows)
    return trees


def cpu_time(call, runs):
    times = []
    for _ in range(runs):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return min(times)


def measured(trees, keywords, runs):
    """Seconds of the whole call and of the C++ fit."""
    texts = {"formula": FORMULA, "parameters": [], "random": keywords.get("random")}
    table = frame_of(trees[["plot", "dbh", "h"]]).table
    whole = cpu_time(lambda: sf.fit(FORMULA, trees, **keywords), runs)
    inside = cpu_time(lambda: _core.fit(table, None, texts, {"threads": 1}, False, None), runs)
    return whole, inside


def main():
    warnings.simplefilter("ignore")
    rows = [int(float(text)) for text in sys.argv[1:]] or [10**3, 10**4, 10**5, 10**6]
    print("| rows | model | whole call (s) | C++ fit (s) | overhead (s) | overhead |")
    print("|---|---|---|---|---|---|")
    for count in rows:
        trees = inventory(count)
        for name, keywords in (("least squares", {}), ("random a", {"random": "a | plot"})):
            whole, inside = measured(trees, keywords, 25 if count <= 10**4 else 9 if count <= 10**5 else 3)
            print(f"| {count} | {name} | {whole:.4f} | {inside:.4f} | {whole - inside:.4f} "
                  f"| {100 * (whole - inside) / inside:.1f} % |", flush=True)


if __name__ == "__main__":
    main()
