# SPDX-License-Identifier: MIT
"""Family "inventories": `silvafit simulate` draws forests of eight kinds, a default `silvafit study` is run on each.

What is recorded: processor seconds, and chosen models that are absurd. Heights are looked at over 1 cm to 1.2 times the largest DBH, for the
population and for every plot, at indices of 0.5 and the mean elevation.
"""

import concurrent.futures
import csv
import json
import math
import pathlib
import shutil
import sys

import cases
import drawn
import fitting
import summary

TREES = 4900
TOLERANCE = 1e-6
# kind: (plots, their sides [m] before scaling, spread between plots as share of a coefficient, shares of species)
KINDS = {
    "ten": (10, lambda draw: 70, 0.05, (0.30, 0.27, 0.25, 0.07, 0.05, 0.03, 0.03)),
    "small": (120, lambda draw: 20, 0.10, (0.60, 0.25, 0.15)),
    "uneven": (30, lambda draw: math.exp(draw.uniform(math.log(5), math.log(80))), 0.10, (0.5, 0.3, 0.15, 0.05)),
    "pure": (25, lambda draw: draw.uniform(25, 60), 0.12, (0.94, 0.06)),
    "wide": (16, lambda draw: draw.uniform(30, 70), 0.30, (0.45, 0.35, 0.20)),
    "few": (4, lambda draw: 110, 0.15, (0.25, 0.25, 0.25, 0.25)),
    "sparse": (25, lambda draw: draw.uniform(25, 60), 0.01, (0.1,) * 10),
    "fir": None,  # examples/fir-mixed
}
HEIGHTS = (
    ("h ~ 1.3 + a*(1 - exp(-b*dbh))", {"a": (18, 36), "b": (0.025, 0.06)}),
    ("h ~ 1.3 + dbh^2/(a + b*dbh)^2", {"a": (1.1, 2.2), "b": (0.16, 0.21)}),
    ("h ~ 1.3 + a*(1 - exp(-b*dbh))^c", {"a": (20, 34), "b": (0.03, 0.07), "c": (0.9, 1.6)}),
    ("h ~ 1.3 + a/(1 + b*exp(-c*dbh))", {"a": (15, 26), "b": (4, 8), "c": (0.08, 0.16)}),
    ("h ~ 1.3 + a*dbh^b", {"a": (1.4, 2.6), "b": (0.55, 0.72)}),
    ("h ~ 1.3 + a*exp(-b/dbh)", {"a": (18, 34), "b": (7, 14)}),
)


def design_of(kind, draw):
    """A design for `silvafit simulate`, about TREES trees."""
    if KINDS[kind] is None:
        return json.loads((cases.FOLDER.parent.parent / "examples" / "fir-mixed" / "design.json").read_text(encoding="utf-8"))
    count, side, spread, shares = KINDS[kind]
    sides = [side(draw) for _ in range(count)]
    scale = math.sqrt(5e4 / sum(length**2 for length in sides))  # 5 ha in all, so that the density is 980 stems/ha
    plots, east = [], 0.0
    for number, length in enumerate(sides, 1):
        length = max(5.0, round(length * scale, 1))
        plots.append({"id": str(number), "x0": round(east, 1), "y0": 0, "x1": round(east + length, 1), "y1": length})
        east += length + 5
    area = sum((plot["x1"] - plot["x0"]) * plot["y1"] for plot in plots) / 1e4
    return {
        "schema": "silvafit-design/1",
        "plots": plots,
        "stems": {"minimum_distance": 0.5, "patch_length": 20},
        "terrain": {"base": 300, "slope_north": 0.05, "hill_sd": 5, "hill_length": 80},
        "neighbors": {"count": 4, "within": "stand"},
        "species": [species(f"S{number}", TREES * share / area, spread, draw) for number, share in enumerate(shares, 1)],
    }


def species(code, density, spread, draw):
    mean = draw.uniform(13, 26)
    return {
        "code": code, "name": f"Species {code}", "density": round(density, 1), "patchiness": round(draw.uniform(0, 0.8), 2),
        "dbh": {"minimum": 5, "mean": round(mean, 1), "sd": round(0.35 * mean, 1), "plot_log_sd": 0.08},
        "h": height(spread, draw),
        "hcb": {"formula": "hcb ~ h/(1 + exp(a + b*dbh))", "fixed": {"a": round(draw.uniform(-0.4, 0.6), 2), "b": round(draw.uniform(-0.01, 0.015), 4)},
                "random": {"effects": ["a"], "variance": [round((2 * spread) ** 2, 5)]}, "sigma": round(draw.uniform(0.5, 1.4), 2)},
        "cw": {"formula": "cw ~ a*dbh^b", "fixed": {"a": round(draw.uniform(0.6, 1.0), 3), "b": round(draw.uniform(0.45, 0.65), 3)},
               "random": {"effects": ["a"], "variance": [round((0.6 * spread) ** 2, 5)]}, "sigma": round(draw.uniform(0.3, 0.7), 2)},
    }


def height(spread, draw):
    """A curve with random effects on its first one or two coefficients."""
    formula, ranges = HEIGHTS[draw.randrange(len(HEIGHTS))]
    fixed = {name: float(f"{draw.uniform(*limits):.3g}") for name, limits in ranges.items()}
    effects = ["a", "b"][:draw.randint(1, 2)]
    sd = [spread * fixed[name] * draw.uniform(0.5, 1) for name in effects]
    random = {"effects": effects, "variance": [float(f"{value**2:.3g}") for value in sd]}
    if len(effects) == 2:
        correlation = round(draw.uniform(-0.9, 0.6), 2)
        random["correlation"] = [[1, correlation], [correlation, 1]]
    model = {"formula": formula, "fixed": fixed, "random": random, "residual_rms": round(draw.uniform(0.8, 2.2), 2)}
    if draw.random() < 0.5:
        model["variance"] = {"function": "power", "delta": 0.4}
    return model


# ---------------------------------------------------------------- looking at the chosen models

def rows_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def likelihood_faults(folder):
    """Mixed models that fit worse than the model without random effects that they contain, or than least squares."""
    found = {}
    for row in rows_of(folder / "tables" / "statistics.csv"):
        found[(row["species"], row["response"], row["level"], row["prediction"])] = row
    for (kind, response, level, prediction), row in found.items():
        if level != "nlme" or prediction != "conditional":
            continue
        simpler = found.get((kind, response, "covariates", "population")) or found.get((kind, response, "ols", "population"))
        ols = found.get((kind, response, "ols", "population"))
        if simpler and float(row["log_likelihood"]) < float(simpler["log_likelihood"]) - summary.TOLERANCE:
            yield f"{kind} {response}: log-likelihood {float(row['log_likelihood']) - float(simpler['log_likelihood']):+.1f} beside least squares"
        if ols and float(row["r2"]) < float(ols["r2"]) - 0.01:
            yield f"{kind} {response}: R2 {float(row['r2']):.3f}, least squares {float(ols['r2']):.3f}"


def write_grid(folder, inventory):
    """Trees of every plot and species over the range of DBH; predictions for them are the curves."""
    largest, plots, elevation = {}, {}, []
    for row in rows_of(inventory):
        if row["dbh"]:
            largest[row["species"]] = max(largest.get(row["species"], 0.0), float(row["dbh"]))
        plots[row["plot"]] = True
        elevation.append(float(row["z"]))
    mean = sum(elevation) / len(elevation)
    rows = [(plot, f"{kind}-{plot}-{step}", kind, f"{1 + step * (1.2 * top - 1) / 40:.3f}", f"{mean:.2f}", 0.5, 0.5, 0.5, 0.5)
            for kind, top in largest.items() for plot in plots for step in range(41)]
    return drawn.write(folder / "grid.csv", "plot,tree,species,dbh,z,W,M,U,C", rows)


def curve_faults(program, folder, grid):
    """Curves that are not finite, positive and, for heights, increasing; crown bases above the tree's top."""
    faults = {}
    for level in ("population", "conditional"):
        out = folder / f"{level}.csv"
        status, _, error, _ = fitting.run([program, "predict", str(folder / "library.json"), str(grid), "--level", level, "--out", str(out), "--quiet"], 60)
        if status != 0:
            yield f"predict: {' '.join(error.split())[:150]}"
            return
        last = {}
        for row in rows_of(out):
            curve = (row["species"], row["plot"])
            for fault, response in faults_of(row, last.get(curve)):
                faults.setdefault((row["species"], response, fault), set()).add(f"{level} {row['plot']}" if level == "conditional" else level)
            last[curve] = row
    for (kind, response, fault), where in faults.items():
        yield f"{kind} {response}: {fault} ({len(where)} curves, {sorted(where)[-1]})"


def faults_of(row, before):
    values = {}
    for response in ("h", "hcb", "cw"):
        text = row.get(f"{response}_pred", "")
        if text in ("", "NA"):
            if "not finite" in row.get("flag", "") and f"{response} not" in row["flag"]:
                yield "not finite", response
            continue
        values[response] = float(text)
        if not math.isfinite(values[response]):
            yield "not finite", response
        elif values[response] < 0:
            yield "negative", response
    if before and "h" in values and before.get("h_pred") not in (None, "", "NA"):
        if values["h"] < float(before["h_pred"]) - TOLERANCE:
            yield "decreasing", "h"
    if "h" in values and "hcb" in values and values["hcb"] > values["h"] + TOLERANCE:
        yield "above the tree", "hcb"


# ---------------------------------------------------------------- running

def study(program, folder, kind, number, seed, limit):
    name = f"inventory-{kind}-{number:02}"
    home = folder / "inventories" / name
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir(parents=True)
    design, inventory = home / "design.json", home / "inventory.csv"
    design.write_text(json.dumps(design_of(kind, drawn.stream(seed, f"inventories-{kind}", number)), indent=1), encoding="ascii")
    result = fitting.Result("inventories", name, "study")
    status, _, error, _ = fitting.run([program, "simulate", str(design), "--seed", str(number), "--out", str(inventory), "--truth", str(home / "truth.json")], 60)
    if status != 0:
        result.ended, result.verdict = "refused", "simulate: " + " ".join(error.split())[:200]
        return result
    status, _, error, result.cpu_seconds = fitting.run([program, "study", str(inventory), "--out", str(home / "study"), "--threads", "1", "--quiet"], limit)
    if status != 0:
        result.ended, result.verdict = "time-out" if status is None else "crash" if status < 0 else "refused", " ".join(error.split())[:200]
        return result
    faults = [*likelihood_faults(home / "study"), *curve_faults(program, home / "study", write_grid(home / "study", inventory))]
    result.converged = not faults
    result.verdict = "; ".join(faults)
    result.estimates = {"trees": len(rows_of(inventory)), "models": len(json.loads((home / "study" / "library.json").read_text())["models"]), "faults": len(faults)}
    return result


def run(chosen, numbers):
    """Studies of inventories by their numbers from 0, the kinds in turn."""
    folder = pathlib.Path(chosen.folder)
    wanted = [(list(KINDS)[number % len(KINDS)], number // len(KINDS) + 1) for number in numbers]
    with concurrent.futures.ThreadPoolExecutor(chosen.jobs) as pool:
        running = [pool.submit(study, chosen.program, folder, kind, number, chosen.seed, max(120.0, chosen.time_out)) for kind, number in wanted]
        for done, _ in enumerate(concurrent.futures.as_completed(running), 1):
            print(f"\r{done} of {len(running)} inventories", end="", file=sys.stderr, flush=True)
        print(file=sys.stderr)
        return [one.result() for one in running]


def studies(results):
    return [one for one in results if one.method == "study"]


def table_of(results):
    """Times and how many are plausible, by kind."""
    rows = []
    for kind in [*KINDS, "all"]:
        mine = [one for one in studies(results) if kind in ("all", one.case.split("-")[1])]
        if mine:
            rows.append([kind, len(mine), sum(one.ended == "yes" for one in mine), sum(one.converged for one in mine),
                         sum(one.cpu_seconds > 5 for one in mine), *summary.seconds([one.cpu_seconds for one in mine])])
    return summary.table(["inventories", "number", "studies that ended", "all models plausible", "over 5 s", "median [s]", "90 % [s]", "longest [s]"], rows)


def fault_table(results):
    faults = [[one.case, one.ended, fault] for one in studies(results) for fault in (one.verdict.split("; ") if one.verdict else [])]
    return summary.table(["inventory", "ended", "fault"], faults) if faults else ""


def report(results):
    """Both tables; nothing without inventories."""
    return f"{table_of(results)}\n\n{fault_table(results)}".strip() if studies(results) else ""
