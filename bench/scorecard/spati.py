# SPDX-License-Identifier: MIT
"""Family "spati": 20 height curves of lmfor's fithd, random effects on the first parameters, three variances.

Curves and the order of their parameters: help page HDmodels of lmfor 1.7 (Mehtatalo, Gregoire and de Miguel 2015, CJFR 45:826-837), but Wykoff's is
without 1.3 m, as the function of that version computes it and as nlme was recorded.
"""

import csv
import math
import re

import cases
import recorded

# Height at DBH d.
CURVES = {
    "naslund": "1.3 + d^2/(a + b*d)^2",
    "curtis": "1.3 + a*(d/(1 + d))^b",
    "michailoff": "1.3 + a*exp(-b/d)",
    "meyer": "1.3 + a*(1 - exp(-b*d))",
    "power": "1.3 + a*d^b",
    "naslund2": "1.3 + d^2/(a + exp(b)*d)^2",
    "naslund3": "1.3 + d^2/(exp(a) + b*d)^2",
    "naslund4": "1.3 + d^2/(exp(a) + exp(b)*d)^2",
    "micment": "1.3 + a*d/(b + d)",
    "micment2": "1.3 + d/(a + b*d)",
    "wykoff": "exp(a + b/(d + 1))",
    "prodan": "1.3 + d^2/(a + b*d + c*d^2)",
    "logistic": "1.3 + a/(1 + b*exp(-c*d))",
    "richards": "1.3 + a*(1 - exp(-b*d))^c",
    "weibull": "1.3 + a*(1 - exp(-b*d^c))",
    "gomperz": "1.3 + a*exp(-b*exp(-c*d))",
    "sibbesen": "1.3 + a*d^(b*d^(-c))",
    "korf": "1.3 + a*exp(-b*d^(-c))",
    "ratkowsky": "1.3 + a*exp(-b/(d + c))",
    "hossfeldIV": "1.3 + a/(1 + 1/(b*d^c))",
}
VARIANCES = ("", "power(d)", "power(w2)")


def family(_folder, _seed):
    nlme = recorded.log_likelihoods("spati")
    for curve, height in CURVES.items():
        for random_effects in range(1, 3 if "c" not in re.findall(r"\b[abc]\b", height) else 4):
            for number, variance in enumerate(VARIANCES):
                name = f"{curve}-{random_effects}-{number}"
                yield cases.Case(family="spati", name=name, data=cases.FOLDER / "data-gpl" / "spati.csv", formula="h ~ " + height,
                                 random=" + ".join("abc"[:random_effects]) + " | plot", variance=variance, nlme=nlme.get(name))


def trees():
    with open(cases.FOLDER / "data-gpl" / "spati.csv", newline="", encoding="ascii") as file:
        return [(float(row["d"]), float(row["h"])) for row in csv.DictReader(file)]


def solve(matrix, right):
    """Gauss-Jordan with pivots, for two or three unknowns."""
    rows = [line[:] + [value] for line, value in zip(matrix, right)]
    for column in range(len(rows)):
        pivot = max(range(column, len(rows)), key=lambda index: abs(rows[index][column]))
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [value / rows[column][column] for value in rows[column]]
        for index, line in enumerate(rows):
            if index != column:
                rows[index] = [value - line[column] * top for value, top in zip(line, rows[column])]
    return [line[-1] for line in rows]


def regression(response, terms):
    """Coefficients of the response of (d, h) on terms of d, by normal equations: good enough for a start."""
    sample = [(response(d, h), [term(d) for term in terms]) for d, h in trees() if h > 1.3]
    gram = [[sum(x[i] * x[j] for _, x in sample) for j in range(len(terms))] for i in range(len(terms))]
    return solve(gram, [sum(x[i] * y for y, x in sample) for i in range(len(terms))])


def one(_d):
    return 1.0


# curve: response of (d, h), terms of d, parameters from the regression's coefficients.
LINEAR = {
    "naslund": (lambda d, h: d / math.sqrt(h - 1.3), (one, lambda d: d), lambda k: k),
    "naslund2": (lambda d, h: d / math.sqrt(h - 1.3), (one, lambda d: d), lambda k: (k[0], math.log(k[1]))),
    "naslund3": (lambda d, h: d / math.sqrt(h - 1.3), (one, lambda d: d), lambda k: (math.log(max(k[0], 0.1)), k[1])),
    "naslund4": (lambda d, h: d / math.sqrt(h - 1.3), (one, lambda d: d), lambda k: (math.log(max(k[0], 0.1)), math.log(max(k[1], 0.1)))),
    "curtis": (lambda d, h: math.log(h - 1.3), (one, lambda d: math.log(d / (1 + d))), lambda k: (math.exp(k[0]), k[1])),
    "michailoff": (lambda d, h: math.log(h - 1.3), (one, lambda d: 1 / d), lambda k: (math.exp(k[0]), -k[1])),
    "power": (lambda d, h: math.log(h - 1.3), (one, math.log), lambda k: (math.exp(k[0]), k[1])),
    "micment": (lambda d, h: d / (h - 1.3), (one, lambda d: d), lambda k: (1 / k[1], k[0] / k[1])),
    "micment2": (lambda d, h: d / (h - 1.3), (one, lambda d: d), lambda k: k),
    "wykoff": (lambda d, h: math.log(h), (one, lambda d: 1 / (d + 1)), lambda k: k),
    "prodan": (lambda d, h: d**2 / (h - 1.3), (one, lambda d: d, lambda d: d**2), lambda k: k),
    "richards": (lambda d, h: math.log(h - 1.3), (one, lambda d: math.log(1 - math.exp(-0.04 * d))), lambda k: (math.exp(k[0]), 0.04, k[1])),
    "ratkowsky": (lambda d, h: math.log(h - 1.3), (one, lambda d: 1 / (d + 5)), lambda k: (math.exp(k[0]), -k[1], 5.0)),
}


def linearised(curve):
    """Parameters of a curve from a regression on its linear form; None for curves without one."""
    if curve not in LINEAR:
        return None
    response, terms, parameters = LINEAR[curve]
    return dict(zip("abc", parameters(regression(response, terms))))
