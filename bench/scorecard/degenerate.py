# SPDX-License-Identifier: MIT
"""Families "degenerate" and "subsets": data that leave a model undetermined, other units of the same data, periods, small samples.

data/deg_base.csv has heights of Meyer's curve: 6 groups of 16, a covariate z without effect. The others change one thing each.
"""

import dataclasses
import math
import re

import cases
import spati
import summary


@dataclasses.dataclass(frozen=True)
class Expected:
    """What a sound end is: a verdict that says one of some words (a regular expression), or else the fit of another case.

    same_as names that case, shift is what its log-likelihood changes by, errors are pairs of coefficients whose standard errors must agree
    within 1 %, here and there. within bounds the absolute value of coefficients.
    """

    says: str = ""
    same_as: str = ""
    shift: float = 0.0
    errors: tuple = ()
    within: tuple = ()

    def judge(self, result, other):
        """ "sound", or what is wrong."""
        if self.says and re.search(self.says, result.verdict):
            return "sound"
        if not result.usable():
            return "not converged" if result.ended == "yes" else result.ended
        for name, bound in self.within:
            if abs(result.estimates.get(name, math.inf)) > bound:
                return f"{name} = {result.estimates.get(name):.3g}"
        if self.same_as:
            return self.compare(result, other)
        return "the verdict does not name it" if self.says else "sound"

    def compare(self, result, other):
        if other is None or not other.usable():
            return f"{self.same_as} has no fit"
        difference = result.log_likelihood - other.log_likelihood - self.shift
        if abs(difference) > summary.TOLERANCE:
            return f"log-likelihood {difference:+.3f} beside {self.same_as}"
        for here, there in self.errors:
            ratio = result.estimates.get(f"se({here})", math.nan) / other.estimates.get(f"se({there})", math.nan)
            if not abs(ratio - 1) < 0.01:
                return f"standard error of {here} {ratio:.3g} times that of {there} in {self.same_as}"
        return "sound"


MEYER = "y ~ 1.3 + a*(1 - exp(-b*x))"
ROWS = 96
# Of deg_*: formula (MEYER if empty), sub-model of b, what is expected.
SETS = {
    "base": ("", "b ~ 1 + z", None),
    "mm": ("y ~ 1300 + a*(1 - exp(-b*x))", "b ~ 1 + z", Expected(same_as="deg-base", shift=-ROWS * math.log(1000), errors=(("b", "b"), ("b:z", "b:z")))),
    "off": ("y ~ 1000001.3 + a*(1 - exp(-b*x))", "b ~ 1 + z", Expected(same_as="deg-base", errors=(("a", "a"), ("b", "b"), ("b:z", "b:z")))),
    "cov1e6": ("", "b ~ 1 + z", Expected(same_as="deg-base", errors=(("a", "a"), ("b:z", "b:z")))),
    "coll": ("", "b ~ 1 + z + z2", Expected(says="b:z and b:z2 are not identifiable")),
    "const": ("", "b ~ 1 + z", Expected(says="perfect fit by the fixed effects")),
    "dup": ("", "b ~ 1 + z", None),
    "gx": ("", "b ~ 1 + z", None),
    "miss": ("", "b ~ 1 + z", None),
    "n5": ("", "b ~ 1 + z", Expected(says="one observation|more parameters|too few|as many parameters|fewer observations|exactly")),
    "onegroup": ("", "b ~ 1 + z", Expected(says=r"one group|single group|sd\(a\) = 0")),
    "outl": ("", "b ~ 1 + z", None),
    "perfect": ("", "b ~ 1 + z", Expected(says="exactly|perfect|no residual|without residual|leaves? no|through (all|every)|(sigma|residual).* (is|are) (zero|0)")),
    "single": ("", "b ~ 1 + z", Expected(says=r"one observation|cor\(a, b\)|sd\(")),
    "twog": ("", "b ~ 1 + z", None),
    "zero": ("", "b ~ 1 + z", None),
}


def family(_folder, _seed):
    """Random effects on both coefficients; those of the perfect curves also on one, and with a power variance."""
    for name, (formula, submodel, expected) in SETS.items():
        yield cases.Case(family="degenerate", name=f"deg-{name}", data=cases.FOLDER / "data" / f"deg_{name}.csv", formula=formula or MEYER,
                         random="a + b | g", parameters=(submodel,), expected=expected)
    perfect = cases.FOLDER / "data" / "deg_perfect.csv"
    for name, random, variance in (("perfect-a", "a | g", ""), ("perfect-power", "a + b | g", "power"), ("perfect-diagonal", "a + b | g", "")):
        yield cases.Case(family="degenerate", name=f"deg-{name}", data=perfect, formula=MEYER, random=random, variance=variance,
                         covariance="diagonal" if "diagonal" in name else "", expected=None if name == "perfect-a" else SETS["perfect"][2])
    yield cases.Case(family="degenerate", name="deg-zero-log", data=cases.FOLDER / "data" / "deg_zero.csv",
                     formula="y ~ a/(1 + exp((b - log(x))/c))", random="a | g", starts={"by eye": "a=25,b=2.3,c=0.7"},
                     expected=Expected(says="hardly depends on b and c"))
    yield from easting_cases()
    yield from period_cases()


def easting_cases():
    """A northing of 6.9 million meters as a covariate, and the same centered."""
    data = cases.FOLDER / "data" / "utm.csv"
    for name, column, expected in (("utm-centered", "nc", None), ("utm", "north", Expected(same_as="utm-centered", errors=(("b:north", "b:nc"),)))):
        for random in ("a", "a + b"):
            same = dataclasses.replace(expected, same_as=f"utm-centered-{random[-1]}") if expected else None
            yield cases.Case(family="degenerate", name=f"{name}-{random[-1]}", data=data, formula="h ~ 1.3 + a*(1 - exp(-b*dbh))",
                             random=f"{random} | plot", parameters=(f"b ~ 1 + {column}",), expected=same)


def period_cases():
    """Observations are 0.1 apart: a frequency above 10 pi is another name of one below it."""
    slow = Expected(within=(("w", 32.0),))
    for number in ("01", "02"):
        data = cases.FOLDER / "data" / f"sin{number}.csv"
        for name, formula, start in (("phase", "y ~ A + B*cos(w*t + 0.7853981633974483)", "A=12,B=-3,w={}"),
                                     ("two", "y ~ A + B*cos(w*t) + C*sin(w*t)", "A=12,B=1,C=1,w={}")):
            yield cases.Case(family="degenerate", name=f"sin{number}-{name}", data=data, formula=formula, random="A | g", expected=slow,
                             starts={f"w = {w}": start.format(w) for w in (4, 6, 8)})


SUBSET_CURVES = ("prodan-1", "richards-2", "weibull-2", "logistic-3", "sibbesen-1", "meyer-2", "korf-2")


def subsets(_folder, _seed):
    """Small samples of the trees of spati, in which lb or laplace once ended below a better optimum."""
    for number in (26, 28, 30, 33):
        for curve_effects in SUBSET_CURVES:
            curve, count = curve_effects.split("-")
            for variance in ("", "power(w2)"):
                yield cases.Case(family="subsets", name=f"sub{number}-{curve}-{count}-{2 if variance else 0}", variance=variance,
                                 data=cases.FOLDER / "data-gpl" / f"sub{number}.csv", formula="h ~ " + spati.CURVES[curve],
                                 random=" + ".join("abc"[:int(count)]) + " | plot")
