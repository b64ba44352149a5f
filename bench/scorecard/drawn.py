# SPDX-License-Identifier: MIT
"""Families of drawn data: "biexp", "fol", "emax", "near-singular".

Each set has a random stream of its own, Python's random.Random seeded with the text "SEED/FAMILY/NUMBER", normal variates by its gauss(): the
same sets on every platform, up to the last digit of the C library's logarithm and cosine, which the rounding of the files hides.
"""

import math
import random

import cases
import recorded

BIEXPONENTIAL = "y ~ A1*exp(-exp(l1)*t) + A2*exp(-exp(l2)*t)"
ABSORPTION = "y ~ 4*exp(lke + lka - lcl)*(exp(-exp(lke)*t) - exp(-exp(lka)*t))/(exp(lka) - exp(lke))"
EMAX = "y ~ exp(lE0) + exp(lEm)*D^g/(exp(g*lED) + D^g)"


def stream(seed, family, number):
    return random.Random(f"{seed}/{family}/{number}")


def write(path, header, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [header] + [",".join(str(value) for value in row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def first(truth, names):
    """Coefficients of a truth, in the order of their names."""
    return {name: truth[name] for name in names}


# ---------------------------------------------------------------- interchangeable terms

def biexponential(draw, truth):
    for group in range(1, 16):
        a1 = truth["A1"] + truth["sd(A1)"] * draw.gauss(0, 1)
        for t in (0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 4, 6, 8):
            mean = a1 * math.exp(-math.exp(truth["l1"]) * t) + truth["A2"] * math.exp(-math.exp(truth["l2"]) * t)
            yield group, t, f"{mean + truth['sigma'] * draw.gauss(0, 1):.6f}"


def biexp(folder, seed):
    truth = {"A1": 2.8, "l1": 0.8, "A2": 0.5, "l2": -1.4, "sd(A1)": 0.5, "sigma": 0.08}
    exchanged = {"A1": 0.5, "l1": -1.4, "A2": 2.8, "l2": 0.8}
    starts = {"the truth": cases.start_text(first(truth, exchanged)), "exchanged terms": cases.start_text(exchanged)}
    nlme = recorded.log_likelihoods("biexp") if seed == 1 else {}
    for name, data in sets(folder, seed, "biexp", "g,t,y", lambda draw: biexponential(draw, truth)):
        yield cases.Case(family="biexp", name=name, data=data, formula=BIEXPONENTIAL, random="A1 | g", truth=truth, starts=starts,
                         nlme=nlme.get(name))


def absorption(draw, truth):
    for group in range(1, 16):
        lka = truth["lka"] + truth["sd(lka)"] * draw.gauss(0, 1)
        lcl = truth["lcl"] + truth["sd(lcl)"] * draw.gauss(0, 1)
        ka, ke = math.exp(lka), math.exp(truth["lke"])
        for t in (0.25, 0.5, 1, 2, 4, 7, 10, 24):
            mean = 4 * ke * ka / math.exp(lcl) * (math.exp(-ke * t) - math.exp(-ka * t)) / (ka - ke)
            yield group, t, f"{mean + truth['sigma'] * draw.gauss(0, 1):.6f}"


def fol(folder, seed):
    truth = {"lka": 0.4, "lke": -2.4, "lcl": -3.2, "sd(lka)": 0.5, "sd(lcl)": 0.2, "cor(lka, lcl)": 0.0, "sigma": 0.4}
    exchanged = {"lka": -2.4, "lke": 0.4, "lcl": -3.2}
    starts = {"the truth": cases.start_text(first(truth, exchanged)), "exchanged terms": cases.start_text(exchanged)}
    nlme = recorded.log_likelihoods("fol") if seed == 1 else {}
    for name, data in sets(folder, seed, "fol", "g,t,y", lambda draw: absorption(draw, truth)):
        yield cases.Case(family="fol", name=name, data=data, formula=ABSORPTION, random="lka + lcl | g", truth=truth, starts=starts,
                         nlme=nlme.get(name))


def sets(folder, seed, family, header, draw_rows):
    """Five sets that the repository ships (drawn in R), then 20 of this seed."""
    for number in range(1, 6):
        yield f"{family}-given-{number:02}", cases.FOLDER / "data" / f"{family}{number:02}.csv"
    for number in range(1, 21):
        yield f"{family}-{number:02}", write(folder / f"{family}{number:02}.csv", header, draw_rows(stream(seed, family, number)))


# ---------------------------------------------------------------- sigmoid Emax

# After Plan, Maloney, Mentre, Karlsson and Bertrand 2012 (AAPS Journal 14:420-432): exponent g, doses of a subject, residuals.
DESIGNS = {"S1": (1, 4, "additive"), "S2": (3, 4, "proportional"), "S3": (2, 2, "additive")}
DOSES = (0, 100, 300, 1000)
PAIRS = ((0, 100), (0, 300), (0, 1000), (100, 300), (100, 1000), (300, 1000))


def dose_response(draw, truth, doses, residuals):
    for subject in range(1, 101):
        z0, zm, zd = draw.gauss(0, 1), draw.gauss(0, 1), draw.gauss(0, 1)
        rho = truth["cor(lEm, lED)"]
        e0 = math.exp(truth["lE0"] + truth["sd(lE0)"] * z0)
        em = math.exp(truth["lEm"] + truth["sd(lEm)"] * zm)
        ed = math.exp(truth["lED"] + truth["sd(lED)"] * (rho * zm + math.sqrt(1 - rho**2) * zd))
        for dose in DOSES if doses == 4 else PAIRS[(subject - 1) % 6]:
            mean = e0 + em * dose ** truth["g"] / (ed ** truth["g"] + dose ** truth["g"])
            sd = truth["sigma"] * (mean if residuals == "proportional" else 1)
            yield subject, dose, f"{mean + sd * draw.gauss(0, 1):.6f}"


def emax(folder, seed):
    nlme = recorded.log_likelihoods("emax") if seed == 1 else {}
    for design, (exponent, doses, residuals) in DESIGNS.items():
        truth = {"lE0": math.log(5), "lEm": math.log(30), "lED": math.log(500), "g": exponent, "sd(lE0)": 0.3, "sd(lEm)": 0.7, "sd(lED)": 0.7,
                 "cor(lEm, lED)": 0.5, "sigma": 0.1 if residuals == "proportional" else 2}
        for number in range(1, 11):
            name = f"emax-{design}-{number:02}"
            data = write(folder / f"emax_{design}_{number:02}.csv", "id,D,y",
                         dose_response(stream(seed, f"emax-{design}", number), truth, doses, residuals))
            yield cases.Case(family="emax", name=name, data=data, formula=EMAX, random="(lEm + lED) + lE0 | id", truth=truth,
                             variance="power(fitted, delta = 1)" if residuals == "proportional" else "", nlme=nlme.get(name),
                             starts={"the truth": cases.start_text(first(truth, ("lE0", "lEm", "lED", "g")))})


# ---------------------------------------------------------------- variances near zero, correlations near one

# Few groups and trees; one standard deviation is (nearly) zero, or two random effects are (nearly) multiples of each other.
# name: formula, f(x; parameters), x of a group of n, groups, rows of a group, truth
NEAR_SINGULAR = {
    "linear-zero": ("y ~ a + b*x", lambda x, a, b: a + b * x, (0, 10), 6, 5,
                    {"a": 10.0, "b": 0.5, "sd(a)": 1.0, "sd(b)": 0.0, "sigma": 1.0}),
    "linear-one": ("y ~ a + b*x", lambda x, a, b: a + b * x, (0, 10), 8, 6,
                   {"a": 10.0, "b": 0.5, "sd(a)": 1.0, "sd(b)": 0.15, "cor(a, b)": 1.0, "sigma": 1.0}),
    "exponential-zero": ("y ~ a*exp(-b*x)", lambda x, a, b: a * math.exp(-b * x), (0, 10), 5, 6,
                         {"a": 20.0, "b": 0.3, "sd(a)": 3.0, "sd(b)": 0.003, "sigma": 0.8}),
    "logistic-zero": ("y ~ a/(1 + exp((b - x)/c))", lambda x, a, b, c: a / (1 + math.exp((b - x) / c)), (0, 20), 7, 7,
                      {"a": 20.0, "b": 9.0, "c": 2.5, "sd(a)": 2.0, "sd(b)": 0.8, "sd(c)": 0.0, "sigma": 1.0}),
    "meyer-one": ("y ~ 1.3 + a*(1 - exp(-b*x))", lambda x, a, b: 1.3 + a * (1 - math.exp(-b * x)), (6, 40), 6, 5,
                  {"a": 25.0, "b": 0.06, "sd(a)": 3.0, "sd(b)": 0.01, "cor(a, b)": -1.0, "sigma": 1.2}),
}
SETS_OF_A_DESIGN = 100


def coefficients(truth):
    return [name for name in truth if name.isidentifier() and name != "sigma"]


def small_sample(draw, curve, span, groups, rows, truth):
    varying = [name for name in coefficients(truth) if f"sd({name})" in truth]
    for group in range(1, groups + 1):
        values = first(truth, coefficients(truth))
        shared = draw.gauss(0, 1)
        for position, name in enumerate(varying):
            correlation = truth.get("cor(a, b)", 0.0) if position else 1.0
            z = correlation * shared + math.sqrt(max(0.0, 1 - correlation**2)) * draw.gauss(0, 1)
            values[name] += truth[f"sd({name})"] * z
        for _ in range(rows):
            x = round(draw.uniform(*span), 3)
            yield group, x, f"{curve(x, **values) + truth['sigma'] * draw.gauss(0, 1):.5f}"


def near_singular(folder, seed):
    nlme = recorded.log_likelihoods("near-singular") if seed == 1 else {}
    for design, (formula, curve, span, groups, rows, truth) in NEAR_SINGULAR.items():
        varying = [name for name in coefficients(truth) if f"sd({name})" in truth]
        for number in range(1, SETS_OF_A_DESIGN + 1):
            name = f"{design}-{number:03}"
            data = write(folder / "near-singular" / f"{name}.csv", "g,x,y",
                         small_sample(stream(seed, design, number), curve, span, groups, rows, truth))
            yield cases.Case(family="near-singular", name=name, data=data, formula=formula, random=" + ".join(varying) + " | g", truth=truth,
                             nlme=nlme.get(name), starts={"the truth": cases.start_text(first(truth, coefficients(truth)))})
