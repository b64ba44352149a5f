# SPDX-License-Identifier: MIT
"""Every kind of data gives the fit that plain arrays give."""
import decimal

import numpy as np
import pandas as pd
import pytest
from arrow_producer import ArrowTable
from conftest import FORMULA

import silvafit as sf

MODEL = dict(random="a | plot", parameters=["b ~ 1 + species"])


@pytest.fixture(scope="module")
def expected(stands):
    return sf.fit(FORMULA, stands, **MODEL)


def same(fit, expected):
    return fit.fixed_effects.equals(expected.fixed_effects) and fit.loglik == expected.loglik


def test_dicts_and_structured_arrays(stands, expected):
    columns = {name: stands[name].to_numpy() for name in stands.columns}
    fit = sf.fit(FORMULA, columns, **MODEL)
    assert same(fit, expected)
    assert isinstance(fit.fitted().index, pd.RangeIndex)
    assert same(sf.fit(FORMULA, stands.to_records(index=False), **MODEL), expected)


@pytest.mark.parametrize("types", [
    {"plot": "category", "species": "category"},
    {"plot": "string", "species": "string"},
    {"dbh": "Float64", "h": "float32"},
    {"h": "Float64", "species": "category"},
    {"dbh": object, "h": object},
])
def test_types_of_pandas(stands, types):
    trees = stands.astype(types)
    plain = stands.assign(h=stands["h"].astype(np.float32).astype(float)) if types.get("h") == "float32" else stands
    assert same(sf.fit(FORMULA, trees, **MODEL), sf.fit(FORMULA, plain, **MODEL))


def test_missing_values_of_every_type_are_skipped(stands):
    plain = stands.copy()
    plain.loc[[0, 5], "h"] = np.nan
    plain.loc[3, "plot"] = None
    plain.loc[9, "species"] = np.nan
    expected = sf.fit(FORMULA, plain, **MODEL)
    assert expected.excluded == 4
    for types in ({"h": "Float64", "plot": "string"}, {"plot": "category", "species": "category"}, {"h": object}):
        fit = sf.fit(FORMULA, plain.astype(types), **MODEL)
        assert same(fit, expected) and fit.excluded == 4
    decimals = plain.assign(dbh=[decimal.Decimal(str(value)) for value in plain["dbh"]])
    assert same(sf.fit(FORMULA, decimals, **MODEL), expected)


def test_labels_of_groups_keep_their_type(stands):
    numbers = stands["plot"].str.slice(1, 2).astype(int) * 100 + stands["plot"].str.slice(3).astype(int)
    for labels, kind in ((numbers, int), (numbers.astype("Int64"), int), (numbers.astype("category"), int),
                         (numbers.astype(str), str)):
        trees = stands.assign(plot=labels)
        fit = sf.fit(FORMULA, trees, random="a | plot")
        assert all(isinstance(label, (kind, np.integer) if kind is int else kind) for label in fit.random_effects.index)
        assert set(fit.random_effects.index) == set(labels)
        assert fit.predict(trees, level="conditional").to_numpy() == pytest.approx(fit.fitted().to_numpy())


def test_numbers_that_are_no_exact_doubles_stay_different_labels(stands):
    codes, _ = pd.factorize(stands["plot"])
    trees = stands.assign(plot=codes.astype(np.int64) + 2**60)
    fit = sf.fit(FORMULA, trees, random="a | plot")
    assert fit.groups == {"plot": 32}
    assert set(fit.random_effects.index) == set(trees["plot"])


def test_views_and_orders_of_memory(stands, expected):
    reversed_twice = stands.iloc[::-1].iloc[::-1]
    assert same(sf.fit(FORMULA, reversed_twice, **MODEL), expected)
    block = np.asfortranarray(stands[["dbh", "h"]].to_numpy())
    columns = {"dbh": block[:, 0], "h": block[:, 1], "plot": stands["plot"], "species": stands["species"]}
    assert same(sf.fit(FORMULA, columns, **MODEL), expected)
    strided = {"dbh": np.repeat(stands["dbh"].to_numpy(), 2)[::2], "h": stands["h"], "plot": stands["plot"],
               "species": stands["species"]}
    assert same(sf.fit(FORMULA, strided, **MODEL), expected)


@pytest.mark.parametrize("text", ["u", "U", "vu", "dictionary"])
@pytest.mark.parametrize("chunks", [1, 3])
def test_arrow_streams(stands, expected, text, chunks):
    table = ArrowTable(stands[["dbh", "h", "plot", "species"]], text=text, chunks=chunks)
    assert same(sf.fit(FORMULA, table, **MODEL), expected)
    assert table.released == table.made


def test_arrow_streams_with_missing_values_and_slices(stands):
    plain = stands[["dbh", "h", "plot", "species"]].copy()
    plain.loc[[0, 7, 500], "h"] = np.nan
    plain.loc[2, "plot"] = None
    expected = sf.fit(FORMULA, plain, **MODEL)
    for offset in (0, 5):
        table = ArrowTable(plain, text="u", chunks=2, offset=offset)
        fit = sf.fit(FORMULA, table, **MODEL)
        assert same(fit, expected) and fit.excluded == 4


def test_arrow_types_of_numbers(stands):
    whole = stands.assign(dbh=stands["dbh"].round(), h=stands["h"].round())
    expected = sf.fit(FORMULA, whole, random="a | plot")
    for kind in ("f", "i", "l", "s", "d:10,2"):
        table = ArrowTable(whole[["dbh", "h", "plot"]], text="u", numbers=kind)
        assert same(sf.fit(FORMULA, table, random="a | plot"), expected)
    flagged = whole.assign(old=whole["dbh"] > 20)
    logical = sf.fit("h ~ a + b*old", ArrowTable(flagged[["h", "old"]], text="u"))
    assert same(logical, sf.fit("h ~ a + b*old", flagged))


def test_only_columns_of_the_model_are_read(stands):
    trees = stands.assign(odd=[[1, 2]] * len(stands))
    assert set(sf.fit(FORMULA, trees).data.columns) == {"h", "dbh"}


def test_the_data_of_a_fit_have_their_types(stands):
    trees = stands.assign(plot=stands["plot"].astype("category").cat.codes.astype(int), old=stands["dbh"] > 20)
    data = sf.fit("h ~ a + b*dbh + c*old", trees, random="a | plot").data
    for name in data.columns:
        assert data[name].equals(trees[name]), name


def test_models_without_predictors_have_the_rows_of_the_data(stands):
    fit = sf.fit("h ~ a", stands)
    for data in (stands, {"dbh": [1.0, 2.0], "species": ["SM", "SM"]}, ArrowTable(stands[["dbh", "plot"]], text="u")):
        count = len(data["dbh"]) if not isinstance(data, ArrowTable) else len(stands)
        assert fit.predict(data).to_numpy() == pytest.approx(np.full(count, stands["h"].mean()))


def test_levels_of_the_index_are_columns(stands, expected):
    trees = stands.set_index(["plot", "tree"])
    fit = sf.fit(FORMULA, trees, **MODEL)
    assert same(fit, expected)
    assert fit.fitted().index.equals(trees.index)
    assert fit.predict(trees, level="conditional").to_numpy() == pytest.approx(fit.fitted().to_numpy())


def test_numbers_of_a_table_are_views(mixed):
    name, values = next(column for column in mixed._frame.table.columns() if column[0] == "dbh")
    again = dict(mixed._frame.table.columns())["dbh"]
    assert np.shares_memory(values, again) and not values.flags.writeable
