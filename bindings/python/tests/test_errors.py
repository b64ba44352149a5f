# SPDX-License-Identifier: MIT
"""Errors name the column, the row and the remedy; warnings have the status."""
import pickle
import warnings

import numpy as np
import pandas as pd
import pytest
from conftest import FORMULA

import silvafit as sf


def test_an_unknown_column_lists_those_that_there_are(stands):
    with pytest.raises(sf.InputError) as caught:
        sf.fit(FORMULA, stands, random="a | plott")
    for name in ("plott", "plot", "species", "crowding"):
        assert name in str(caught.value)
    assert isinstance(caught.value, ValueError)


def test_messages_have_keyword_arguments(inventory):
    with pytest.raises(sf.InputError) as caught:
        sf.structural_units(inventory.assign(h=100 * inventory["h"]))
    assert 'use columns={"h": "h/100"}; if it is correct, use trust_units=True' in str(caught.value)
    with pytest.raises(sf.UsageError, match="^alpha: 181 ") as caught:
        sf.structural_units(inventory, alpha=["181"])
    assert caught.value.column == "alpha"


def test_a_formula_error_points_at_its_place(stands):
    with pytest.raises(sf.FormulaError) as caught:
        sf.fit("h ~ 1.3 + a*(1 - exp(-b*dbh)", stands)
    assert caught.value.position is not None
    assert "^" in str(caught.value)


def test_a_text_among_numbers_names_its_row(stands):
    trees = stands.astype({"dbh": object})
    trees.index = trees.index + 1000
    trees.loc[1007, "dbh"] = "thick"
    with pytest.raises(sf.Error) as caught:
        sf.fit(FORMULA, trees)
    assert caught.value.column == "dbh"
    assert "thick" in str(caught.value)
    assert caught.value.row == 1007
    assert pickle.loads(pickle.dumps(caught.value)).row == 1007


def test_a_value_outside_the_domain_names_its_row(inventory):
    trees = inventory.set_index(inventory["plot"].astype(str) + "-" + inventory["tree"].astype(str))
    label = trees.index[10]
    trees.loc[label, "h"] = 0.5
    with pytest.raises(sf.DomainError) as caught:
        sf.fit("M4", trees)
    assert caught.value.row == label and caught.value.column == "h"


def test_unknown_arguments_and_values_are_refused(stands):
    with pytest.raises(sf.UsageError, match="did you mean start"):
        sf.fit(FORMULA, stands, stat={"a": 30})
    with pytest.raises(sf.UsageError, match="nlmixed"):
        sf.fit(FORMULA, stands, method="nlmixed")
    with pytest.raises(sf.UsageError, match="start"):
        sf.fit(FORMULA, stands, start={"a": "large"})
    with pytest.raises(sf.UsageError, match="M999"):
        sf.fit("M999", stands)
    fit = sf.fit(FORMULA, stands)
    with pytest.raises(sf.UsageError, match="calibrated"):
        fit.predict(stands, level="best")
    with pytest.raises(sf.UsageError, match="pearson"):
        fit.residuals("odd")
    with pytest.raises(sf.UsageError, match="unknown argument"):
        sf.structural_units({"x": [1.0]}, egde="none")


@pytest.mark.parametrize("data", [3, "inventory.csv", [1, 2], None])
def test_what_is_no_table_is_refused(data):
    with pytest.raises(TypeError):
        sf.fit(FORMULA, data)


def test_columns_of_different_lengths_are_refused():
    with pytest.raises(TypeError, match="dbh"):
        sf.fit(FORMULA, {"h": np.ones(3), "dbh": np.ones(4)})
    twice = pd.DataFrame([[1.0, 2.0, 3.0]], columns=["h", "dbh", "dbh"])
    with pytest.raises(TypeError, match="two columns"):
        sf.fit(FORMULA, twice)


def test_a_fit_without_a_maximum_is_a_result_with_a_warning():
    # a and c are the same parameter twice.
    x = np.linspace(1.0, 10.0, 30)
    data = {"x": x, "y": 2.0 + 0.5 * x + 0.1 * np.sin(7 * x)}
    with pytest.warns(sf.ConvergenceWarning) as caught:
        fit = sf.fit("y ~ a + c + b*x", data)
    assert not fit.converged and fit.status == "not_identifiable"
    assert caught[0].message.status == "not_identifiable"
    assert caught[0].filename == __file__
    assert "not_identifiable" in str(caught[0].message)
    assert "NOT CONVERGED" in str(fit.summary())
    with pytest.raises(sf.UsageError):
        fit.simulate()


def test_a_boundary_fit_warns_and_a_sound_one_does_not(stands):
    x = np.tile(np.linspace(1.0, 10.0, 8), 6)
    noise = np.tile([0.1, -0.1, 0.05, -0.05, -0.1, 0.1, -0.05, 0.05], 6) * np.repeat([1, -1, 1, -1, 1, -1], 8)
    data = {"x": x, "y": 1.0 + 2.0 * x + noise, "plot": np.repeat(np.arange(6), 8)}
    with pytest.warns(sf.ConvergenceWarning) as caught:
        fit = sf.fit("y ~ a + b*x", data, random="a | plot")
    assert fit.status == "boundary" == caught[0].message.status
    assert "sd(a)" in set(fit.evidence["term"])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sf.fit(FORMULA, stands, random="a | plot")


@pytest.mark.parametrize("name", ["model", "columns", "factors", "catalogue", "knows_units"])
def test_what_fit_passes_on_is_no_argument(stands, name):
    with pytest.raises(sf.UsageError, match=f"unknown argument '{name}'"):
        sf.fit("h ~ a + b*dbh", stands, **{name: "M8"})
