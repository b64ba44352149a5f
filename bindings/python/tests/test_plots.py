# SPDX-License-Identifier: MIT
"""Plots show the numbers of the fit."""
import numpy as np
import pytest
from conftest import FORMULA

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

import silvafit as sf  # noqa: E402


def test_curves_of_groups_are_predictions(mixed):
    ax = mixed.plot(groups=["S1P1", "S2P1"])
    curves = {line.get_label(): line for line in ax.lines}
    assert {"S1P1", "S2P1", "population"} <= set(curves)
    x, y = curves["S1P1"].get_data()
    expected = mixed.predict({"dbh": x, "plot": ["S1P1"] * len(x)}, level="conditional")
    assert np.asarray(y, float) == pytest.approx(expected.to_numpy())
    assert ax.get_xlabel() == "dbh" and ax.get_ylabel() == "h"
    with pytest.raises(sf.UsageError, match="nowhere"):
        mixed.plot(groups=["nowhere"])


def test_residuals_and_random_effects(mixed):
    ax = mixed.plot("residuals")
    points = next(line for line in ax.lines if len(line.get_xdata()) == mixed.nobs)
    assert np.asarray(points.get_ydata()) == pytest.approx(mixed.residuals("pearson").to_numpy())
    ax = mixed.plot("residuals", residual="response", level="population")
    points = next(line for line in ax.lines if len(line.get_xdata()) == mixed.nobs)
    assert np.asarray(points.get_ydata()) == pytest.approx(mixed.residuals("response", "population").to_numpy())
    with pytest.raises(sf.UsageError, match="available: residual, level"):
        mixed.plot("residuals", resdual="response")
    ax = mixed.plot("random", effect="b")
    container = ax.containers[0]
    middle = container.lines[0].get_xdata()
    assert np.asarray(middle, float) == pytest.approx(np.sort(mixed.random_effects["b"].to_numpy()))
    with pytest.raises(sf.UsageError):
        mixed.plot("pie")


def test_normal_quantiles(mixed):
    scipy_stats = pytest.importorskip("scipy.stats")
    ax = mixed.plot("qq")
    points, line = ax.lines
    values = np.sort(mixed.residuals("normalized"))
    assert np.asarray(points.get_ydata()) == pytest.approx(values)
    # R's ppoints() of more than 10 values.
    assert np.asarray(points.get_xdata()) == pytest.approx(scipy_stats.norm.ppf((np.arange(len(values)) + 0.5) / len(values)))
    # R's qqline(): through the quartiles.
    on_line = np.interp(scipy_stats.norm.ppf([0.25, 0.75]), *line.get_data())
    assert on_line == pytest.approx(np.quantile(values, [0.25, 0.75]))
    effects = mixed.plot("qq", effect="b").lines[0]
    assert np.asarray(effects.get_ydata()) == pytest.approx(np.sort(mixed.random_effects["b"]))
    with pytest.raises(sf.UsageError, match="unknown effect 'c'; available: a, b"):
        mixed.plot("qq", effect="c")
    with pytest.raises(sf.UsageError, match="no random effects"):
        sf.fit(FORMULA, mixed.data).plot("qq", effect="a")


def test_plots_of_other_models(stands):
    matplotlib.pyplot.close("all")
    sf.fit(FORMULA, stands).plot()
    nested = sf.fit(FORMULA, stands, random="a | stand/plot")
    nested.plot(groups=["S1/S1P1"])
    nested.plot("random")
    numbers = stands.assign(plot=stands["plot"].astype("category").cat.codes)
    ax = sf.fit(FORMULA, numbers, random="a | plot").plot(groups=[3])
    assert "3" in [line.get_label() for line in ax.lines]
    with_factor = sf.fit(FORMULA, stands, parameters="b ~ 1 + species", random="a | plot")
    with_factor.plot()
    figure, ax = matplotlib.pyplot.subplots()
    assert with_factor.plot("residuals", ax=ax) is ax
    with pytest.raises(sf.UsageError, match="no random effects"):
        sf.fit(FORMULA, stands).plot("random")
    matplotlib.pyplot.close("all")
