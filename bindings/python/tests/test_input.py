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


def test_restrictions_that_depend_on_each_other_are_named(fit):
    for texts, message in (("a = 20, 2*a = 40", "'2*a = 40' follows from 'a = 20'"),
                           ("a = 20, a = 30", "'a = 30' contradicts 'a = 20'"),
                           ("a + b = 1, a = 0, b = 1", "'b = 1' follows from 'a + b = 1' and 'a = 0'"),
                           ("a + b = 1, a = 0, b = 2", "'b = 2' contradicts 'a + b = 1' and 'a = 0'")):
        with pytest.raises(sf.UsageError) as caught:
            fit.f_test(texts)
        assert message in str(caught.value)
    # Coefficients of very different units are independent.
    wide = fit.update("h ~ 1.3 + a*(1 - exp(-b*1e-9*dbh))")
    for tested in (fit, wide):
        estimate, covariance = tested.fixed_effects.to_numpy(), tested.covariance.to_numpy()
        test = tested.f_test("a = 20, b = 0")
        distance = estimate - [20.0, 0.0]
        assert test["statistic"] == pytest.approx(distance @ np.linalg.solve(covariance, distance) / 2, rel=1e-6)


@pytest.mark.parametrize("arguments, column", [
    ({"method": "ML", "reml": True}, "reml"), ({"method": "REML", "reml": False}, "reml")])
def test_words_of_the_method_do_not_contradict_reml(stands, arguments, column):
    with pytest.raises(sf.UsageError) as caught:
        sf.fit(FORMULA, stands, random="a | plot", **arguments)
    assert caught.value.column == column


def test_words_of_the_method_change_a_fit(fit):
    restricted = fit.update(method="REML")
    assert restricted.reml and not restricted.update(method="ML").reml and not fit.reml
    assert restricted.update(method="ML").loglik == fit.loglik


def test_arguments_without_effect_are_refused(fit, stands):
    library = sf.Library.of(fit)
    for call, column in ((lambda: fit.predict(stands, coverage=0.5), "coverage"),
                         (lambda: library.predict(stands, coverage=0.5), "coverage"),
                         (lambda: fit.predict(stands, seen_groups="new"), "seen_groups"),
                         (lambda: fit.predict(stands, level="population", new_groups="error"), "new_groups"),
                         (lambda: fit.residuals("normalized", level="population"), "level"),
                         (lambda: fit.get_prediction(stands, coverage=0.5), "coverage")):
        with pytest.raises(sf.UsageError) as caught:
            call()
        assert caught.value.column == column


@pytest.mark.parametrize("options", [
    {"random": "a | h"}, {"random": "a | plot/h"}, {"variance": "power(h)"}, {"variance": "stratum(h)"}, {"parameters": "a ~ h"}])
def test_the_response_does_not_explain_itself(stands, options):
    for formula in (FORMULA, "log(h) ~ a + b*log(dbh)"):
        with pytest.raises(sf.FormulaError, match="'h' cannot predict itself"):
            sf.fit(formula, stands, **options)


def test_models_of_the_catalogue_predict_where_the_program_does(stands, program, tmp_path):
    """As in files: dbh of 0 and codes are missing, other impossible values stop."""
    fit = sf.fit("M4", stands, random="a | plot")
    fit.to_json(tmp_path / "fit.json")
    new = stands.head(8).assign(dbh=[0.0, -999.0, 20.0, 30.0, *stands["dbh"][4:8]], h=[*stands["h"][:6], -9999.0, np.nan])
    new.to_csv(tmp_path / "new.csv", index=False)
    for level in ("population", "conditional", "calibrated"):
        program("predict", tmp_path / "fit.json", tmp_path / "new.csv", "--level", level, "--digits", 17, "--out", tmp_path / "out.csv")
        with pytest.warns(sf.SilvafitWarning, match="codes read as missing values: .*dbh 2"):
            ours = fit.predict(new, level=level)
        assert ours.to_numpy() == pytest.approx(pd.read_csv(tmp_path / "out.csv")["h_pred"].to_numpy(), rel=1e-14, nan_ok=True)
        assert ours.isna().sum() == 2
    unmeasured = new.assign(h=new["h"].where(new["h"] > 0)).iloc[2:]
    with pytest.warns(sf.SilvafitWarning, match="h 1 .-9999"):
        assert fit.calibrate(new.iloc[2:]).equals(fit.calibrate(unmeasured))
    for column, value in (("dbh", -1.0), ("h", -5.0)):
        wrong = stands.head(3).copy()
        wrong.loc[1, column] = value
        with pytest.raises(sf.DomainError) as caught:
            fit.predict(wrong, level="calibrated")
        assert (caught.value.row, caught.value.column) == (1, column)


def test_an_empty_text_among_numbers_is_a_missing_value(stands, inventory):
    gaps = stands.astype({"dbh": object})
    gaps.loc[[2, 5], "dbh"] = ["", " "]
    expected = sf.fit(FORMULA, stands.drop(index=[2, 5]))
    assert sf.fit(FORMULA, gaps).loglik == pytest.approx(expected.loglik, rel=1e-13)
    trees = inventory.astype({"h": object})
    trees.loc[1, "h"] = ""
    assert np.isnan(sf.structural_units(trees)["h"][1])


def test_rows_of_data_without_an_index_are_counted_as_pandas_does(stands):
    heights = stands["h"].to_numpy().copy()
    heights[0] = np.inf
    with pytest.raises(sf.InputError, match="^row 0: h: ") as caught:
        sf.fit(FORMULA, {"h": heights, "dbh": stands["dbh"].to_numpy()})
    assert caught.value.row == 0


def test_labels_of_tables_have_the_types_of_the_data(inventory):
    days = pd.Timestamp("2020-01-01") + pd.to_timedelta(inventory["plot"], unit="D")
    for plots in (inventory["plot"], inventory["plot"] + 0.5, days, inventory["plot"].astype(str)):
        trees = inventory.assign(plot=plots).rename(columns={"plot": "Plot_ID"})
        units = sf.structural_units(trees)
        assert units["plot"].dtype == plots.dtype and (units["plot"] == plots[units.index]).all()
        assert units["tree"].dtype == inventory["tree"].dtype
        stand = sf.stand_summary(trees, plot_area=400)
        assert stand.plots["plot"].dtype == plots.dtype and set(stand.plots["plot"]) == set(plots)
        effects = sf.fit(FORMULA, trees.rename(columns={"Plot_ID": "plot"}), random="a | plot").random_effects
        assert set(effects.index) == set(plots)
    strata = sf.stand_summary(inventory.assign(half=inventory["plot"] % 2), plot_area=400, stratum="half").tables["strata"]
    assert strata["stratum"].tolist() == [0, 1, "all"]
    years = pd.concat([inventory.assign(year=2010), inventory.assign(year=2020)], ignore_index=True)
    growth = sf.stand_growth(years, plot_area=400)["growth_trees"]
    assert growth[["plot", "tree", "from", "to"]].dtypes.map(str).tolist() == ["int64"] * 4
    assert set(growth["from"]) == {2010} and set(growth["to"]) == {2020}


def test_times_are_labels_whatever_the_other_rows(inventory):
    days = pd.Timestamp("2020-01-01") + pd.to_timedelta(inventory["plot"], unit="D")
    trees = inventory.assign(day=days)
    fit = sf.fit(FORMULA, trees, random="a | day")
    noon = trees.head(1).assign(day=trees["day"] + pd.Timedelta("12h"))
    with pytest.warns(sf.SilvafitWarning, match="1 row is of groups that are not in the fit .day 2020-01-02 12:00:00"):
        predicted = fit.predict(pd.concat([trees.head(1), noon], ignore_index=True))
    assert predicted[0] == fit.fitted()[0] and predicted[1] != predicted[0]


def test_columns_of_the_user_are_not_replaced(inventory):
    with pytest.raises(sf.UsageError) as caught:
        sf.structural_units(inventory.assign(W="wide"))
    assert caught.value.column == "W"
    units = sf.structural_units(inventory)
    assert sf.structural_units(units).equals(units)


def test_the_tables_of_a_stand_have_its_thinning(inventory):
    stand = sf.stand_summary(inventory, plot_area=400, thinning="below=20")
    table = stand.tables["thinning"].set_index("plot")
    assert set(table.index) == {*inventory["plot"], "all"}
    name = "basal_area_m2_per_ha_"
    assert (table[name + "removed"] + table[name + "after"]).to_numpy() == pytest.approx(table[name + "before"].to_numpy(), rel=1e-12)
    assert (table[name + "after"] >= 20.0).all() and table.loc["all", name + "before"] == pytest.approx(
        (np.pi / 4 * (inventory["dbh"] / 100) ** 2).sum() / (10 * 0.04), rel=1e-12)
    removed = stand.tables["trees"]["removed"] == 1
    assert removed.sum() * 25 / 10 == pytest.approx(table.loc["all", "stems_per_ha_removed"], rel=1e-12)


def test_circles_on_a_map_count_the_trees_in_them():
    rng = np.random.default_rng(1)
    trees = pd.DataFrame({"plot": 1, "tree": range(500), "species": "A", "x": rng.uniform(-25, 25, 500), "y": rng.uniform(-25, 25, 500),
                          "dbh": rng.uniform(10, 30, 500)})
    per_ha = (np.hypot(trees["x"], trees["y"]) <= 8).sum() / (np.pi * 0.0064)
    for shift in (0.0, 1000.0):
        moved = trees.assign(x=trees["x"] + shift)
        for how in ({"circles": {0: 8}, "plots": {"plot": [1], "x": [shift], "y": [0.0]}},
                    {"plots": {"plot": [1], "radius": [8.0], "x": [shift], "y": [0.0]}}, {"circle": f"{shift},0,8"}):
            assert sf.stand_summary(moved, **how).plots["stems_per_ha"][0] == pytest.approx(per_ha, rel=1e-12)
        with pytest.raises(sf.InputError, match="farther apart than these are wide.*give the centers of plots"):
            sf.stand_summary(moved, circles={0: 8})
    with pytest.raises(sf.InputError, match="origin or the centers of `?plots"):
        sf.stand_summary(trees, circles={0: 8}, plots={"plot": [1], "x": [500.0], "y": [0.0]})


def test_measurements_of_whole_millimeters_are_not_rounded(inventory):
    millimeters = (10 * inventory["dbh"]).round().astype(int)
    units = sf.structural_units(inventory.assign(dbh=millimeters), columns={"dbh": "dbh/10"})
    assert units["dbh"].to_numpy() == pytest.approx(millimeters[units.index].to_numpy() / 10, rel=1e-14)


def test_integers_are_numbers_where_doubles_hold_them():
    y = np.array([1.0, 2.0, 3.5, 4.0, 5.2])
    exact = 10**17 + np.arange(5) * 10**15  # multiples of 2**15
    slope, intercept = np.polyfit(np.arange(5.0), y, 1)
    fit = sf.fit("y ~ a + b*(t - 1e17)/1e15", {"y": y, "t": exact})
    assert fit.fixed_effects.to_numpy() == pytest.approx([intercept, slope])
    with pytest.raises(sf.InputError, match="beyond 2.*astype"):
        sf.fit("y ~ a + b*t", {"y": y, "t": exact + 1})
