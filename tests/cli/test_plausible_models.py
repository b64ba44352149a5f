# SPDX-License-Identifier: MIT
"""What a study chooses in drawn inventories, judged from its files alone: curves that trees can have, and reasons for the others.

With SILVAFIT_INVENTORIES=N, N inventories of each design are drawn instead of one.
"""

import csv
import json
import math
import os
import resource
import statistics
import unittest
from pathlib import Path

from silvafit_program import ProgramTest

FIR = json.loads((Path(__file__).parents[2] / "examples" / "fir-mixed" / "design.json").read_text(encoding="utf-8"))
POINTS = 200


def design(plots, size, species, spread=1.0, density=1.0, true_height=None):
    """A part of the example's forest on other plots.

    plots: how many; size: their sides in m; species: codes; spread: factor on the plots' variances; density: factor on stems per ha;
    true_height: formula and coefficients of the heights of all species.
    """
    chosen = [json.loads(json.dumps(one)) for one in FIR["species"] if one["code"] in species]
    for one in chosen:
        one["density"] *= density
        one["patchiness"] = 0.3
        for response in ("h", "hcb", "cw"):
            random = one[response].get("random")
            if random:
                random["variance"] = [spread * value for value in random["variance"]]
        if true_height:
            one["h"] = {"formula": true_height[0], "fixed": true_height[1], "random": {"effects": ["a"], "variance": [true_height[2] * spread]},
                        "sigma": 1.5}
    grid = {"columns": plots, "rows": 1, "width": size, "height": size, "gap": 10}
    return {**FIR, "plots": {"grid": grid}, "terrain": {"base": 100}, "species": chosen, "neighbors": {"count": 4, "within": "stand"}}


DESIGNS = {
    # 25 small plots, as in many inventories.
    "small-plots": design(25, 22, ("MH", "SM"), density=1.6),
    # Plots with about three trees of each species.
    "three-trees": design(60, 12, ("SM", "MH"), density=0.8),
    # Few plots that differ much.
    "few-plots": design(5, 50, ("BHN", "OF"), spread=4.0, density=2.0),
    # Nearly no difference between plots, so that variances end at zero.
    "alike": design(12, 30, ("MH", "VF"), spread=0.02, density=2.5),
    # Sigmoid heights, which convex curves fit in part of the range.
    "sigmoid": design(15, 30, ("MH", "OF"), density=2.0,
                      true_height=("h ~ 1.3 + a*(1 - exp(-b*dbh))^c", {"a": 20.0, "b": 0.12, "c": 2.0}, 4.0)),
    # Heights that are nearly a line in DBH: upper limits cannot be known.
    "line": design(12, 30, ("SM", "VF"), density=1.5, true_height=("h ~ 1.3 + a*dbh^b", {"a": 0.7, "b": 0.95}, 0.01)),
}


def evaluate(formula, values):
    names = {"exp": math.exp, "log": math.log, "sqrt": math.sqrt, **values}
    return eval(formula.split("~")[1].replace("^", "**"), {"__builtins__": {}}, names)


def parameters_of(model, trees, plot):
    """Values of the parameters for a plot, or for the population."""
    own = [tree for tree in trees if plot is None or tree["plot"] == plot]
    coefficients = {name: entry["estimate"] for name, entry in model["fixed"].items()}
    if plot is not None and model["random"]:
        for name, value in model["random"][-1]["eblup"].get(plot, {}).items():
            coefficients[name] += value
    # Parameters without a sub-model are coefficients themselves.
    values = {name: value for name, value in coefficients.items() if ":" not in name}
    for name, text in model["parameters"].items():
        total = 0.0
        for term in (part.strip() for part in text.split("+")):
            if term == "1":
                total += coefficients[name]
            elif term != "0":
                total += coefficients[f"{name}:{term}"] * statistics.median(float(tree[term]) for tree in own)
        values[name] = total
    return values


def flaw(response, model, trees, plot):
    """What is absurd about a curve, or None."""
    parameters = parameters_of(model, trees, plot)
    top = 1.2 * max(float(tree["dbh"]) for tree in trees)
    largest = max(float(tree[response]) for tree in trees)
    last = -math.inf
    for k in range(1, POINTS + 1):
        dbh = top * k / POINTS
        try:
            # Crown bases of the catalogue are shares of the height, so that any height shows them.
            value = evaluate(model["formula"], {**parameters, "dbh": dbh, "h": 10.0})
        except (ZeroDivisionError, OverflowError, ValueError) as error:
            return f"{error} at {dbh:.1f} cm"
        if isinstance(value, complex) or not math.isfinite(value) or value < 0.0:
            return f"{value} at {dbh:.1f} cm"
        if response == "hcb" and value > 10.001:
            return f"{value / 10.0:.2f} of the height at {dbh:.1f} cm"
        if response != "hcb" and value > 2.5 * largest:
            return f"{value:.1f} at {dbh:.1f} cm, where {largest} is the largest measured"
        if response == "h" and value < last - 0.002:
            return f"falls from {last:.3f} to {value:.3f} at {dbh:.1f} cm"
        last = value
    return None


class ChosenModels(ProgramTest):
    def study(self, name, seed):
        """The chosen models, the trees they were fitted to, what the study says, and its processor time."""
        self.write("design.json", json.dumps(DESIGNS[name]))
        self.run_program("simulate", "design.json", "--out", "inventory.csv", "--truth", "truth.json", "--seed", str(seed), "--quiet")
        if name == "three-trees":
            self.remove_positions()
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        said = self.run_json("study", "inventory.csv", "--out", "out", "--edge", "none")
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        library = json.loads((self.folder / "out" / "library.json").read_text(encoding="utf-8"))
        with open(self.folder / "out" / "predictions.csv", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        return library["models"], rows, said["results"], seconds

    def remove_positions(self):
        """So few trees have no structural units within their plots."""
        with open(self.folder / "inventory.csv", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        columns = ("plot", "tree", "species", "dbh", "h", "hcb", "cw")
        lines = [",".join(row[column] for column in columns) for row in rows]
        self.write("inventory.csv", "\n".join([",".join(columns), *lines]) + "\n")

    def check(self, name, seed):
        models, rows, results, seconds = self.study(name, seed)
        said = {(result["species"], result["response"]): result for result in results}
        for model in models:
            species, response = model["species"], model["response"]
            trees = [row for row in rows if row["species"] == species and all(row.get(key, "0") != "" for key in ("dbh", response, "W", "C"))]
            doubts = said[species, response]["doubts"]
            fit = model["fit"]
            plots = [None, *sorted({tree["plot"] for tree in trees})]
            found = [f"plot {plot}: {text}" for plot in plots if (text := flaw(response, fit, trees, plot))]
            self.assertTrue(not found or doubts, f"{name} {seed} {species} {response} {model['role']}: {fit['formula']}: {found[:3]}")
        self.check_likelihoods(models, f"{name} {seed}")
        return seconds, sum(not result["sound"] for result in results), len(results)

    def check_likelihoods(self, models, where):
        by_role = {(model["species"], model["response"], model["role"]): model["fit"] for model in models}
        for (species, response, role), fit in by_role.items():
            if role != "nlme":
                continue
            simpler = by_role[species, response, "covariates"]
            self.assertGreater(fit["log_likelihood"], simpler["log_likelihood"] - 0.01, f"{where} {species} {response}")

    def test_come_from_the_next_base_model_where_one_has_no_mixed_model(self):
        # In this inventory the parabola of crown widths falls below zero with every random effect.
        _, _, results, _ = self.study("few-plots", 4)
        crown = next(result for result in results if (result["species"], result["response"]) == ("BHN", "cw"))
        if not any("All mixed models built on it" in sentence for sentence in crown["rejected"]):
            self.skipTest("the base model that was chosen first has a mixed model")
        self.assertNotEqual(crown["model"], "M23")
        self.assertTrue(crown["converged"])

    def test_are_plausible_or_called_doubtful(self):
        count = int(os.environ.get("SILVAFIT_INVENTORIES", "1"))
        for name in DESIGNS:
            for seed in range(1, count + 1):
                with self.subTest(design=name, seed=seed):
                    seconds, doubtful, all_results = self.check(name, seed)
                    if count > 1:
                        print(f"{name} {seed}: {seconds:.1f} s, {doubtful} of {all_results} doubtful", flush=True)


if __name__ == "__main__":
    unittest.main()
