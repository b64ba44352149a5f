# SPDX-License-Identifier: MIT
"""What one case of the scorecard is: a file, a model, what is known of its fit."""

import dataclasses
import pathlib
import re

FOLDER = pathlib.Path(__file__).resolve().parent
MARGINAL = ("laplace", "focei", "agq")
MIXED = ("lb",) + MARGINAL


@dataclasses.dataclass(frozen=True)
class Case:
    """A model of one file of data.

    random, variance, covariance, parameters and options are those of `silvafit fit`. nlme is the log-likelihood that R's nlme
    (of gnls, lme) was recorded with, None where it failed. truth has the coefficients that drawn data come from, and by names
    such as sd(a), cor(a, b) and sigma the variance components. starts are texts for --start by a name of where they come from.
    expected, a degenerate.Expected, says what a sound end is where that is not simply the best fit.
    """

    family: str
    name: str
    data: pathlib.Path
    formula: str
    random: str = ""
    variance: str = ""
    covariance: str = ""
    parameters: tuple = ()
    options: tuple = ()
    methods: tuple = MIXED
    nlme: float | None = None
    truth: dict | None = None
    starts: dict = dataclasses.field(default_factory=dict)
    expected: object = None

    def arguments(self, method, start=""):
        """Of `silvafit`, for this case by one method."""
        words = ["fit", str(self.data), "--formula", self.formula, "--method", method, "--json", "--quiet", "--threads", "1"]
        for option, value in (("--random", self.random), ("--variance", self.variance), ("--covariance", self.covariance), ("--start", start)):
            words += [option, value] if value else []
        for parameter in self.parameters:
            words += ["--parameter", parameter]
        return words + list(self.options)


def methods_for(random):
    """lb and the marginal methods; agq takes at most three random effects of one grouping."""
    nested = ";" in random or "/" in random
    return MIXED[:-1] if nested or len(effects(random)) > 3 else MIXED


def effects(random):
    """Coefficients with random effects, of one grouping: "(a + b) + c | g" gives a, b, c."""
    return [word.strip(" ()") for word in random.split("|")[0].split("+")]


def start_text(values):
    return ",".join(f"{name}={value:.15g}" for name, value in values.items())


def contained(case, methods):
    """(why, model that the case contains) with a likelihood that it must reach: without random effects, fewer of them, a diagonal
    covariance, a constant variance. Only for one grouping without blocks; REML values of other models do not compare.
    """
    if not case.random or ";" in case.random or "(" in case.random or "--reml" in case.options:
        return []
    coefficients, group = effects(case.random), case.random.split("|")[1].strip()
    found = [("no random effects", dataclasses.replace(case, random="", covariance="", methods=("gnls" if case.variance else "ols",)))]
    if len(coefficients) > 1:
        for left_out in coefficients:
            rest = " + ".join(one for one in coefficients if one != left_out)
            found.append((f"without {left_out}", dataclasses.replace(case, random=f"{rest} | {group}", methods=methods)))
        if not case.covariance:
            found.append(("diagonal", dataclasses.replace(case, covariance="diagonal", methods=methods)))
    if re.match(r"(power|constant-plus-power)(\((?!.*=)|$)", case.variance):
        found.append(("constant variance", dataclasses.replace(case, variance="", methods=methods)))
    return found
