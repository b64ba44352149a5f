# SPDX-License-Identifier: MIT
"""Fits of nlme 3.1-162 (tests/reference/expected/README.md), through the whole package."""
import json

import numpy as np
import pandas as pd
import pytest
from conftest import FORMULA

import silvafit as sf

# nlme stops at its tolerances; its numbers agree with the maximum to about 5 digits. `fixed_point` has
# the same method without tolerances; its sigma and exponent are correlated,
# so that both are known to fewer than its 8 digits.
NLME = 2e-4
FIXED_POINT = 1e-6

RANDOM = {"stand_a_plot_ab": "a | stand; a + b | plot", "a_in_both": "a | stand/plot"}


@pytest.fixture(scope="module")
def expected(source):
    return lambda name: json.loads((source / "tests/reference/expected" / name).read_text())


@pytest.mark.parametrize("name", ["stand_a_plot_ab_none_ml", "a_in_both_none_ml", "stand_a_plot_ab_power_ml",
                                  "a_in_both_power_ml"])
def test_nested_fits_are_those_of_nlme(expected, stands, name):
    reference = next(fit for fit in expected("nlme_nested.json")["fits"] if fit["id"] == name)
    structure, variance, _ = name.rsplit("_", 2)
    fit = sf.fit("h ~ 1.3 + a*(1 - exp(-b*dbh/10))", stands, random=RANDOM[structure], variance=variance)
    exact = reference["fixed_point"]
    assert fit.loglik == pytest.approx(exact["logLik"], abs=1e-6)
    for coefficient, value in exact["estimates"].items():
        assert fit.fixed_effects[coefficient] == pytest.approx(value, rel=FIXED_POINT)
        assert fit.standard_errors[coefficient] == pytest.approx(reference["std_errors"][coefficient], rel=NLME)
    assert fit.sigma == pytest.approx(exact["sigma"], rel=FIXED_POINT)
    for column, level in reference["random"].items():
        effects = fit.random_effects[column]
        labels = ["/".join(label) if isinstance(label, tuple) else label for label in effects.index]
        ours = pd.DataFrame(effects.to_numpy(), labels, effects.columns).loc[level["groups"], level["names"]]
        scale = np.array(level["sd"])
        assert np.abs((ours.to_numpy() - np.array(level["effects"])) / scale).max() < 1e-3
        assert np.sqrt(np.diag(fit.random_covariance[column])) == pytest.approx(level["sd"], rel=1e-3)


@pytest.mark.parametrize("name", ["stand_a_plot_ab_none_ml", "a_in_both_none_ml"])
def test_coefficients_of_groups_are_sums_of_the_effects_of_nlme(expected, stands, name):
    reference = next(fit for fit in expected("nlme_nested.json")["fits"] if fit["id"] == name)
    fit = sf.fit("h ~ 1.3 + a*(1 - exp(-b*dbh/10))", stands, random=RANDOM[name.rsplit("_", 2)[0]])
    effects = {}
    for level in reference["random"].values():
        for group, values in zip(level["groups"], level["effects"]):
            effects[group] = dict(zip(level["names"], values))
    fixed = reference["fixed_point"]["estimates"]
    for (stand, plot), row in fit.group_coefficients["plot"].iterrows():
        for coefficient in ("a", "b"):
            parts = [effects[group].get(coefficient, 0.0) for group in (stand, f"{stand}/{plot}")]
            assert row[coefficient] == pytest.approx(fixed[coefficient] + sum(parts), rel=NLME)
    assert list(fit.group_coefficients["stand"].index) == list(fit.random_effects["stand"].index)


def test_predictions_are_those_of_nlme(expected, stands):
    for reference in expected("nlme_predict.json")["predictions"]:
        fit = sf.fit(reference["formula"], stands, random=reference["random"], variance=reference["variance"])
        rows = stands.iloc[np.array(reference["rows"]) - 1]
        population, conditional = reference["levels"][0], reference["levels"][-1]
        assert fit.predict(rows, level="population").to_numpy() == pytest.approx(population, rel=NLME)
        assert fit.predict(rows, level="conditional").to_numpy() == pytest.approx(conditional, rel=NLME)


def test_residuals_are_those_of_nlme(expected, stands):
    for reference in expected("nlme_residuals.json")["fits"]["residuals"]:
        random = {"nested": "a | stand/plot", "none": "a | plot"}.get(reference["id"], "a + b | plot")
        fit = sf.fit(FORMULA, stands, random=random, variance=reference["variance"])
        rows = np.array(reference["rows"]) - 1
        values = reference["residuals"]
        for series, name in ((fit.fitted("population"), "fitted_population"), (fit.fitted(), "fitted_conditional"),
                             (fit.residuals(), "response_conditional"), (fit.residuals("pearson"), "pearson_conditional"),
                             (fit.residuals("pearson", "population"), "pearson_population")):
            # Residuals are differences of numbers near 20 m.
            assert series.iloc[rows].to_numpy() == pytest.approx(values[name], rel=NLME, abs=2e-3)
