# SPDX-License-Identifier: MIT
"""Families "curves" and "samples": growth, dose and compartment curves with random effects on one to three parameters, and small samples of spati.

The true values of each drawn set are a design's own, each times exp(0.15 z), z standard normal, so that no two sets have the same curve.
"""

import csv
import dataclasses
import math
import random

import cases
import drawn
import spati


@dataclasses.dataclass(frozen=True)
class Design:
    """A curve in the formula language and in Python, its true values, the spread of its random effects as shares of them."""

    formula: str
    curve: object
    truth: dict
    spread: dict
    at: tuple
    groups: int
    sigma: float
    proportional: bool = False
    variance: str = ""


def logistic(x):
    return 1 / (1 + math.exp(-max(-500.0, min(500.0, x))))


def preece_baines(t, h1, ht, s0, s1, th):
    return h1 - 2 * (h1 - ht) / (math.exp(s0 * (t - th)) + math.exp(s1 * (t - th)))


def bateman(t, lka, lke, lcl):
    ka, ke = math.exp(lka), math.exp(lke)
    return 4 * ke * ka / math.exp(lcl) * (math.exp(-ke * t) - math.exp(-ka * t)) / (ka - ke)


def sum_of_logistics(t, a1, b1, c1, a2, b2, c2):
    return a1 * logistic((t - b1) / c1) + a2 * logistic((t - b2) / c2)


def biphasic(x, lo, hi, f, m1, m2, s):
    return lo + (hi - lo) * (f * logistic((x - m1) / s) + (1 - f) * logistic((x - m2) / s))


def two_exponentials(t, A1, l1, A2, l2):
    return A1 * math.exp(-math.exp(l1) * t) + A2 * math.exp(-math.exp(l2) * t)


YEARS = tuple(range(2, 20))
WEEKS = tuple(range(0, 21))
HOURS = (0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4, 6, 8)
DOSES = (-3, -2.5, -2, -1.5, -1, -0.5, 0, 0.5, 1, 1.5, 2, 2.5, 3)

TWO_LOGISTICS = {"a1": 8.0, "b1": 5.0, "c1": 0.9, "a2": 12.0, "b2": 14.0, "c2": 1.6}
GROWTH = {"h1": 174.0, "ht": 162.0, "s0": 0.11, "s1": 1.2, "th": 14.0}
PHASES = {"lo": 0.5, "hi": 10.0, "f": 0.4, "m1": -1.4, "m2": 1.5, "s": 0.35}
DECAY = {"A1": 2.8, "l1": 0.8, "A2": 0.5, "l2": -1.4}
ABSORPTION = {"lka": 0.4, "lke": -2.4, "lcl": -3.2}

FORMULAS = {
    "logistics": "y ~ a1/(1 + exp((b1 - x)/c1)) + a2/(1 + exp((b2 - x)/c2))",
    "biphasic": "y ~ lo + (hi - lo)*(f/(1 + exp((m1 - x)/s)) + (1 - f)/(1 + exp((m2 - x)/s)))",
    "preece": "y ~ h1 - 2*(h1 - ht)/(exp(s0*(x - th)) + exp(s1*(x - th)))",
    "decay": "y ~ A1*exp(-exp(l1)*x) + A2*exp(-exp(l2)*x)",
    "absorption": "y ~ 4*exp(lke + lka - lcl)*(exp(-exp(lke)*x) - exp(-exp(lka)*x))/(exp(lka) - exp(lke))",
    "fourpl": "y ~ A + (B - A)/(1 + exp((xm - x)/sc))",
    "gompertz": "y ~ a*exp(-b*exp(-c*x))",
    "weibull": "y ~ A - D*exp(-exp(r)*x^p)",
}


def fourpl(x, A, B, xm, sc):
    return A + (B - A) * logistic((x - xm) / sc)


def gompertz(x, a, b, c):
    return a * math.exp(-b * math.exp(-c * x))


def weibull(x, A, D, r, p):
    return A - D * math.exp(-math.exp(r) * x**p)


FOURPL = {"A": 1.0, "B": 20.0, "xm": 9.0, "sc": 2.0}
GOMPERTZ = {"a": 25.0, "b": 3.5, "c": 0.25}
WEIBULL = {"A": 160.0, "D": 115.0, "r": -5.5, "p": 2.4}

DESIGNS = {
    "logistics-a1": Design(FORMULAS["logistics"], sum_of_logistics, TWO_LOGISTICS, {"a1": 0.25}, YEARS, 12, 0.4),
    "logistics-2": Design(FORMULAS["logistics"], sum_of_logistics, TWO_LOGISTICS, {"a2": 0.2, "b1": 0.1}, YEARS, 12, 0.4),
    "biphasic-hi": Design(FORMULAS["biphasic"], biphasic, PHASES, {"hi": 0.2}, DOSES, 10, 0.3),
    "biphasic-3": Design(FORMULAS["biphasic"], biphasic, PHASES, {"hi": 0.2, "f": 0.2, "m1": 0.2}, DOSES, 12, 0.2),
    "preece-h1": Design(FORMULAS["preece"], preece_baines, GROWTH, {"h1": 0.03}, YEARS, 12, 0.8),
    "preece-3": Design(FORMULAS["preece"], preece_baines, GROWTH, {"h1": 0.03, "s1": 0.1, "th": 0.05}, YEARS, 15, 0.5),
    "decay-A1": Design(FORMULAS["decay"], two_exponentials, DECAY, {"A1": 0.2}, HOURS, 12, 0.08),
    "decay-l2": Design(FORMULAS["decay"], two_exponentials, DECAY, {"l2": 0.25}, HOURS, 12, 0.04),
    "decay-3": Design(FORMULAS["decay"], two_exponentials, DECAY, {"A1": 0.2, "l1": 0.3, "A2": 0.3}, HOURS, 12, 0.1, True, "power"),
    "absorption-ka": Design(FORMULAS["absorption"], bateman, ABSORPTION, {"lka": 1.2}, (0.25, 0.5, 1, 2, 4, 7, 10, 24), 12, 0.4),
    "absorption-3": Design(FORMULAS["absorption"], bateman, ABSORPTION, {"lka": 1.0, "lke": 0.08, "lcl": 0.08}, (0.25, 0.5, 1, 2, 4, 7, 10, 24), 14, 0.12, True,
                           "constant-plus-power"),
    "fourpl-2": Design(FORMULAS["fourpl"], fourpl, FOURPL, {"B": 0.2, "xm": 0.15}, (1, 4, 7, 10, 13, 16), 12, 0.6),
    "fourpl-3": Design(FORMULAS["fourpl"], fourpl, FOURPL, {"A": 0.5, "B": 0.2, "xm": 0.15}, (1, 3, 5, 7, 9, 11, 13, 15), 10, 0.08, True, "power"),
    "gompertz-3": Design(FORMULAS["gompertz"], gompertz, GOMPERTZ, {"a": 0.2, "b": 0.2, "c": 0.15}, (1, 3, 5, 8, 11, 14, 18), 10, 0.06, True, "power"),
    "gompertz-few": Design(FORMULAS["gompertz"], gompertz, GOMPERTZ, {"a": 0.25, "c": 0.25}, (2, 6, 11, 18), 14, 1.0),
    "weibull-2": Design(FORMULAS["weibull"], weibull, WEIBULL, {"A": 0.1, "D": 0.15}, WEEKS[::2], 10, 4.0, False, "exponential(x)"),
}
SETS_OF_A_DESIGN = 4


def rows(draw, design, truth):
    for group in range(1, design.groups + 1):
        values = {name: truth[name] * (1 + design.spread.get(name, 0.0) * draw.gauss(0, 1)) for name in design.truth}
        for x in design.at:
            mean = design.curve(x, *values.values())
            sd = design.sigma * (abs(mean) if design.proportional else 1)
            yield group, x, f"{mean + sd * draw.gauss(0, 1):.6f}"


def drawn_truth(draw, design):
    """Coefficients near the design's own; those that are logarithms or places keep their sign."""
    return {name: value * math.exp(0.15 * draw.gauss(0, 1)) if abs(value) < 100 else value * math.exp(0.02 * draw.gauss(0, 1))
            for name, value in design.truth.items()}


def family(folder, seed):
    for design_name, design in DESIGNS.items():
        for number in range(1, SETS_OF_A_DESIGN + 1):
            draw = drawn.stream(seed, design_name, number)
            truth = drawn_truth(draw, design)
            name = f"{design_name}-{number:02}"
            data = drawn.write(folder / "curves" / f"{name}.csv", "g,x,y", rows(draw, design, truth))
            yield cases.Case(family="curves", name=name, data=data, formula=design.formula, random=" + ".join(design.spread) + " | g",
                             variance=design.variance, starts={"the truth": cases.start_text(truth)})


# ---------------------------------------------------------------- small samples of spati

SAMPLES = 40
VARIANCES = ("", "power(d)", "constant-plus-power(d)", "exponential(d)")


def samples(folder, seed):
    """Each a curve, a number of random effects, a variance function and 12 to 25 plots of spati by chance."""
    with open(cases.FOLDER / "data-gpl" / "spati.csv", newline="", encoding="ascii") as file:
        trees = list(csv.DictReader(file))
    plots = sorted({row["plot"] for row in trees}, key=int)
    for number in range(1, SAMPLES + 1):
        draw = random.Random(f"{seed}/samples/{number}")
        chosen = set(draw.sample(plots, draw.randint(12, 25)))
        curve = draw.choice(sorted(spati.CURVES))
        parameters = [name for name in "abc" if any(name == word for word in words(spati.CURVES[curve]))]
        effects = parameters[:draw.randint(1, len(parameters))]
        variance = draw.choice(VARIANCES)
        name = f"sample-{number:02}-{curve}-{len(effects)}-{VARIANCES.index(variance)}"
        data = drawn.write(folder / "samples" / f"{name}.csv", "plot,d,h", [(row["plot"], row["d"], row["h"]) for row in trees if row["plot"] in chosen])
        yield cases.Case(family="samples", name=name, data=data, formula="h ~ " + spati.CURVES[curve], random=" + ".join(effects) + " | plot",
                         variance=variance)


def words(formula):
    return "".join(letter if letter.isalnum() else " " for letter in formula).split()
