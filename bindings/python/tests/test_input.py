# SPDX-License-Identifier: MIT
"""Arguments and data as users give them by mistake, and as other packages make them."""
import numpy as np
import pandas as pd
import pytest
from conftest import FORMULA

import silvafit as sf


@pytest.fixture(scope="module")
def fit(stands):
    return sf.fit(FORMULA, stands, random="a | plot")


@pytest.mark.parametrize("argument, value", [
    ("threads", -1), ("threads", 1.5), ("threads", True), ("starts", -1), ("agq_points", 0), ("maximum_iterations", -1),
    ("maximum_iterations", 10**10), ("random", ["a"]), ("variance", 1), ("method", 3), ("covariance", {}),
    ("parameters", [1]), ("parameters", 1)])
def test_an_argument_of_a_wrong_type_or_range_is_named(stands, argument, value):
    with pytest.raises(sf.UsageError) as caught:
        sf.fit(FORMULA, stands, **{"random": "a | plot", argument: value})
    assert caught.value.column == argument


def test_arguments_of_methods_are_named(fit, stands):
    for call, argument in ((lambda: sf.fit(None, stands), "formula"), (lambda: fit.intervals(None), "method"),
                           (lambda: fit.intervals(level="wide"), "level"), (lambda: fit.intervals(threads=-1), "threads"),
                           (lambda: fit.simulate(-1), "count"), (lambda: fit.simulate(1.5), "count"),
                           (lambda: fit.simulate(seed="first"), "seed"), (lambda: fit.simulate(seed=-1), "seed"),
                           (lambda: fit.calibrate(stands, seen_groups=None), "seen_groups")):
        with pytest.raises(sf.UsageError) as caught:
            call()
        assert caught.value.column == argument
    with pytest.raises(sf.UsageError, match="list"):
        sf.compare([fit, fit])
    assert fit.simulate(np.int64(2), seed=np.uint32(1)).equals(fit.simulate(2, seed=1))


def test_start_values_may_be_those_of_another_fit(fit, stands):
    again = sf.fit(FORMULA, stands, start=fit.fixed_effects)
    assert again.loglik == pytest.approx(sf.fit(FORMULA, stands).loglik)


def test_masked_values_are_missing(stands):
    heights = np.ma.masked_less(stands["h"].to_numpy(), 15.0)
    masked = sf.fit(FORMULA, {"h": heights, "dbh": stands["dbh"].to_numpy()})
    assert masked.nobs == (stands["h"] >= 15.0).sum() < len(stands)
    assert masked.loglik == pytest.approx(sf.fit(FORMULA, stands[stands["h"] >= 15.0]).loglik)


def test_large_whole_numbers_are_different_labels(stands, fit):
    numbers = stands["plot"].astype("category").cat.codes.astype(object)
    for labels in (numbers + 10**30, (numbers + 2**60).astype("Int64").where(stands.index > 0)):
        large = sf.fit(FORMULA, stands.assign(plot=labels), random="a | plot")
        assert large.groups == fit.groups
        assert set(large.random_effects.index) == set(labels.dropna())


def test_labels_are_those_of_the_data(stands):
    codes = stands["plot"].astype("category").cat.codes
    for labels in ([(code, "x") for code in codes], [None if k == 0 else code > 3 for k, code in enumerate(codes)]):
        effects = sf.fit(FORMULA, stands.assign(plot=pd.Series(labels, dtype=object)), random="a | plot").random_effects
        assert set(effects.index) == set(labels) - {None}


def test_an_empty_text_is_a_missing_value(stands):
    first = stands["plot"] == stands["plot"].iloc[0]
    expected = sf.fit(FORMULA, stands[~first], random="a | plot")
    texts = stands["plot"].astype(str).where(~first, "")
    for labels in (texts, texts.astype("category"), texts.astype("string")):
        trees = stands.assign(plot=labels)
        gaps = sf.fit(FORMULA, trees, random="a | plot")
        assert gaps.excluded == first.sum()
        assert gaps.loglik == pytest.approx(expected.loglik)
        predicted = gaps.predict(trees, level="conditional")
        assert predicted[~first].to_numpy() == pytest.approx(gaps.fitted()[~first].to_numpy())


def test_columns_that_cannot_be_used_are_named(stands):
    size = len(stands)
    for values in ([[1]] * size, [{}] * size, [b"\xff"] * size):
        with pytest.raises(TypeError, match="plot: "):
            sf.fit(FORMULA, stands.assign(plot=values), random="a | plot")
    with pytest.raises(TypeError, match="h: one value"):
        sf.fit(FORMULA, {"h": 1.0, "dbh": [1.0, 2.0]})


def test_series_of_different_indices_are_refused(stands):
    with pytest.raises(TypeError, match="dbh: the index"):
        sf.fit(FORMULA, {"h": stands["h"], "dbh": stands["dbh"].iloc[::-1]})


def test_calibration_needs_measured_numbers(fit, stands):
    few = stands.iloc[:3]
    for data in (few.drop(columns="h"), few.assign(h="20"), few.assign(h=np.inf)):
        for call in (lambda table: fit.predict(table, level="calibrated"), fit.calibrate):
            with pytest.raises(sf.Error) as caught:
                call(data)
            assert "h" in str(caught.value)
    none = few.assign(h=np.nan, plot="new")
    assert fit.predict(none, level="calibrated").equals(fit.predict(none))
